import type { ComponentChildren } from "preact";

import { address, go } from "../router";

interface Props {
  /** From the page's root: "/plans". */
  to: string;
  class?: string;
  current?: boolean;
  children: ComponentChildren;
}

/** To another room, without loading the page anew; as a new tab it works like any link. */
export function Link({ to, class: name, current, children }: Props) {
  return (
    <a
      href={address(to)}
      class={name}
      aria-current={current ? "page" : undefined}
      onClick={(event) => {
        if (event.button || event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
        event.preventDefault();
        go(to);
      }}
    >
      {children}
    </a>
  );
}
