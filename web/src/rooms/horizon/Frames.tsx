/** The images, dropped or chosen, one for each camera in its order. */
import { useEffect, useMemo, useState } from "preact/hooks";

import ahead from "../../../../examples/horizon_ahead.png?url";
import right from "../../../../examples/horizon_right.png?url";
import { words } from "../../i18n";

interface Props {
  /** Their names, in the request's order. */
  cameras: string[];
  frames: File[];
  onFrames: (frames: File[]) => void;
}

export function Frames({ cameras, frames, onFrames }: Props) {
  const text = words.value.horizon;
  const [isOver, setOver] = useState(false);
  const previews = useMemo(() => frames.map((frame) => URL.createObjectURL(frame)), [frames]);
  useEffect(() => () => previews.forEach((preview) => URL.revokeObjectURL(preview)), [previews]);
  const take = (files: FileList | null | undefined) => {
    if (files?.length) onFrames([...frames, ...files].slice(-Math.max(cameras.length, 1)));
  };
  const takeExample = async () => {
    const files = [ahead, right].map(async (address, index) => {
      const image = await (await fetch(address)).blob();
      return new File([image], ["ahead.png", "right.png"][index] ?? "frame.png", { type: "image/png" });
    });
    onFrames(await Promise.all(files));
  };
  return (
    <div
      class={`drop ${isOver ? "drop-over" : ""}`}
      onDragOver={(event) => {
        event.preventDefault();
        setOver(true);
      }}
      onDragLeave={() => setOver(false)}
      onDrop={(event) => {
        event.preventDefault();
        setOver(false);
        take(event.dataTransfer?.files);
      }}
    >
      <p>{text.drop}</p>
      <div class="row">
        <label class="button">
          {text.choose}
          <input
            class="hidden"
            type="file"
            multiple
            accept="image/png,image/jpeg,image/tiff"
            onChange={(event) => {
              take(event.currentTarget.files);
              event.currentTarget.value = "";
            }}
          />
        </label>
        <button type="button" onClick={() => void takeExample()}>
          {text.example}
        </button>
        {frames.length > 0 && (
          <button type="button" onClick={() => onFrames([])}>
            {text.clear}
          </button>
        )}
      </div>
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
    </div>
  );
}
