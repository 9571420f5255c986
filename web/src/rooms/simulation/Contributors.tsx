/** Contributors to misses and to smear, the greatest first. */
import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import type { Flights } from "./flights";

export function Contributors({ contributors }: Pick<Flights, "contributors">) {
  const text = words.value.simulation;
  return (
    <div class="scroll-x" tabIndex={0} role="region" aria-label={text.share}>
      <p class="hint">{text.contributorsHint}</p>
      <table>
        <thead>
          <tr>
            <th scope="col">{text.cause}</th>
            <th scope="col">{text.share}</th>
            <th scope="col">{text.smearShare}</th>
          </tr>
        </thead>
        <tbody>
          {contributors.map((one) => (
            <tr key={one.cause}>
              <th scope="row">{words.value.service.told(one.cause)}</th>
              <Share share={one.share} sigma={one.share_sigma} />
              <Share share={one.smear_share} sigma={one.smear_share_sigma} />
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Share({ share, sigma }: { share: number; sigma: number }) {
  return (
    <td>
      <meter min={0} max={1} value={Math.min(Math.max(share, 0), 1)} aria-hidden="true" />{" "}
      <span class="nowrap">
        {number(100 * share)} ± {number(100 * sigma)} %
      </span>
    </td>
  );
}
