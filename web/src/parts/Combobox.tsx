/** A text field that offers how what is typed may go on (the ARIA combobox with a list). */
import { useEffect, useId, useRef, useState } from "preact/hooks";

import { words } from "../i18n";
import type { Control } from "./Field";

export interface Offer {
  /** What the field takes. */
  value: string;
  /** What is read beside it. */
  told: string;
}

interface Props {
  control: Control;
  value: string;
  onValue: (value: string) => void;
  /** Chosen from the list. */
  onTake: (value: string) => void;
  /** Left with what was typed. */
  onLeave: () => void;
  /** The name of the list. */
  offered: string;
  /** null: nothing is to be asked for. */
  offers: (begun: string, until: AbortSignal) => Promise<readonly Offer[]> | null;
}

const QUIET_MS = 150; // typing isn't yet asking

export function Combobox({ control, value, onValue, onTake, onLeave, offered, offers }: Props) {
  const list = useId();
  const [shown, setShown] = useState<readonly Offer[]>([]);
  const [active, setActive] = useState(-1);
  const asking = useRef<AbortController | null>(null);
  const close = () => {
    asking.current?.abort();
    setShown([]);
    setActive(-1);
  };
  useEffect(() => () => asking.current?.abort(), []);
  const ask = (begun: string) => {
    close();
    const wanted = new AbortController();
    asking.current = wanted;
    const timer = setTimeout(() => {
      // Without offers the name can still be typed: whether it means a place is told when it is taken.
      offers(begun, wanted.signal)?.then(
        (found) => wanted.signal.aborted || setShown(found),
        () => undefined,
      );
    }, QUIET_MS);
    wanted.signal.addEventListener("abort", () => clearTimeout(timer));
  };
  const take = (offer: Offer) => {
    close();
    onValue(offer.value);
    onTake(offer.value);
  };
  const key = (event: KeyboardEvent) => {
    const count = shown.length;
    const offer = shown[active];
    if (event.key === "ArrowDown" && count === 0) ask(value);
    else if (event.key === "ArrowDown") setActive((active + 1) % count);
    else if (event.key === "ArrowUp" && count > 0) setActive(active <= 0 ? count - 1 : active - 1);
    else if (event.key === "Escape" && count > 0) close();
    else if (event.key === "Enter" && offer) take(offer);
    else if (event.key === "Enter")
      return close(); // it is taken as it is typed
    else return;
    event.preventDefault();
  };
  const isOpen = shown.length > 0;
  return (
    <span class="combobox">
      <input
        {...control}
        type="text"
        role="combobox"
        aria-autocomplete="list"
        aria-expanded={isOpen}
        aria-controls={list}
        aria-activedescendant={active < 0 ? undefined : `${list}-${active}`}
        autoComplete="off"
        spellcheck={false}
        value={value}
        onInput={(event) => {
          onValue(event.currentTarget.value);
          ask(event.currentTarget.value);
        }}
        onClick={() => value === "" && ask("")}
        onKeyDown={key}
        onBlur={() => {
          close();
          onLeave();
        }}
      />
      <ul id={list} role="listbox" aria-label={offered} hidden={!isOpen}>
        {shown.map((offer, number) => (
          <li
            key={offer.value}
            id={`${list}-${number}`}
            role="option"
            aria-selected={number === active}
            // The field keeps the focus.
            onMouseDown={(event) => event.preventDefault()}
            onClick={() => take(offer)}
          >
            {offer.value} <span class="small">{offer.told}</span>
          </li>
        ))}
      </ul>
      <span class="hidden" role="status">
        {isOpen ? words.value.shell.offered(shown.length) : ""}
      </span>
    </span>
  );
}
