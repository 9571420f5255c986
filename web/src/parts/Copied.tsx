import { useState } from "preact/hooks";

import { words } from "../i18n";

interface Props {
  name: string;
  content: string;
  isOpen?: boolean;
}

/** A text to be taken away, folded, with a button that copies it. */
export function Copied({ name, content, isOpen = false }: Props) {
  const text = words.value.plan.take;
  const [isCopied, setIsCopied] = useState(false);
  const copy = async () => {
    await navigator.clipboard.writeText(content);
    setIsCopied(true);
    setTimeout(() => setIsCopied(false), 2000);
  };
  return (
    <details open={isOpen} class="copied">
      <summary>
        <h3>{name}</h3>
      </summary>
      <pre tabIndex={0} aria-label={name}>
        {content}
      </pre>
      <button type="button" class="small-button" onClick={() => void copy()}>
        {text.copy(name)}
      </button>
      <span role="status" class="small">
        {isCopied ? ` ${text.copied}` : ""}
      </span>
    </details>
  );
}
