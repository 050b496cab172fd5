// Alternatives as a strip of small pictures.
import { useEffect, useRef } from "preact/hooks";
import { adopt, alternatives, seek, seeking, type Alternative } from "./gallery";
import { doc } from "./document";

function Thumbnail({ alternative, position }: { alternative: Alternative; position: number }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const { image, score, lights } = alternative;
  useEffect(() => {
    if (image) canvas.current?.getContext("2d")?.putImageData(image, 0, 0);
  }, [image]);
  return (
    <li>
      <button
        type="button"
        class="thumbnail"
        aria-label={`Alternative ${position + 1}, F ${score.toFixed(4)}`}
        aria-pressed={doc.value?.lights === lights}
        onClick={() => adopt(alternative, position)}
      >
        <canvas ref={canvas} width={image?.width ?? 1} height={image?.height ?? 1} aria-hidden="true" />
        <span class="number">{score.toFixed(3)}</span>
      </button>
    </li>
  );
}

export function Strip() {
  const found = alternatives.value;
  return (
    <section class="strip" aria-labelledby="strip-title" aria-busy={seeking.value}>
      <h2 id="strip-title">Alternatives</h2>
      {found.length > 0 && (
        <ul>
          {found.map((alternative, position) => (
            <Thumbnail key={alternative.index} alternative={alternative} position={position} />
          ))}
        </ul>
      )}
      {found.length === 0 && <p class="note">{seeking.value ? "Looking for other good lights…" : "Other lights that are as good, and look different."}</p>}
      <button type="button" class="button" disabled={!doc.value || seeking.value} onClick={seek}>
        {seeking.value ? "Looking…" : found.length > 0 ? "Find others" : "Find alternatives"}
      </button>
    </section>
  );
}
