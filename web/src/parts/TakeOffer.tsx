import type { Offer } from "../api/offer";
import { words } from "../i18n";
import { rowClock } from "../i18n/forms";

/** The button that asks again with the times that a refusal offers. */
export function TakeOffer({ offer, take }: { offer: Offer; take: () => void }) {
  const text = words.value.shell.offer;
  return (
    <p>
      <button type="button" class="primary" onClick={take}>
        {text.take(rowClock(offer.start), rowClock(offer.stop))}
      </button>
      {offer.without.length > 0 && <span class="small"> {text.without(offer.without.map((one) => one + 1).join(", "))}</span>}
    </p>
  );
}
