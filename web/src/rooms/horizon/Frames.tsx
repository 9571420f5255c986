/** The images, dropped or chosen, one for each camera in its order. */
import { useEffect, useMemo } from "preact/hooks";

import ahead from "../../../../examples/horizon_ahead.png?url";
import right from "../../../../examples/horizon_right.png?url";
import { words } from "../../i18n";
import { DropZone } from "../../parts/DropZone";

interface Props {
  /** Their names, in the request's order. */
  cameras: string[];
  frames: File[];
  onFrames: (change: (now: File[]) => File[]) => void;
}

export function Frames({ cameras, frames, onFrames }: Props) {
  const text = words.value.horizon;
  const previews = useMemo(() => frames.map((frame) => URL.createObjectURL(frame)), [frames]);
  useEffect(
    () => () => {
      for (const preview of previews) URL.revokeObjectURL(preview);
    },
    [previews],
  );
  const take = (frame: File) => onFrames((now) => [...now, frame].slice(-Math.max(cameras.length, 1)));
  const takeExample = async () => {
    const files = [ahead, right].map(async (address, index) => {
      const image = await (await fetch(address)).blob();
      return new File([image], ["ahead.png", "right.png"][index] ?? "frame.png", { type: "image/png" });
    });
    const taken = await Promise.all(files);
    onFrames(() => taken);
  };
  return (
    <>
      <DropZone label={text.choose} accept="image/png,image/jpeg,image/tiff" multiple onFile={take}>
        <p>{text.drop}</p>
        <div class="row">
          <button type="button" onClick={() => void takeExample()}>
            {text.example}
          </button>
          {frames.length > 0 && (
            <button type="button" onClick={() => onFrames(() => [])}>
              {text.clear}
            </button>
          )}
        </div>
      </DropZone>
      <ol class="frames">
        {frames.map((frame, index) => (
          <li key={previews[index]}>
            <img src={previews[index]} alt={text.frameOf(cameras[index] ?? frame.name)} />
            <span class="small">
              {cameras[index] ?? "?"}: {frame.name}
            </span>
          </li>
        ))}
      </ol>
    </>
  );
}
