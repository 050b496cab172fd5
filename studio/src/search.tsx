// The search: start, pause, step, and its curve.
import { IconButton } from "./icons";
import { curve, pause, progress, start, state, step, stop, touched, type Point } from "./searching";

const WIDTH = 320;
const HEIGHT = 96;

/** The best F against the evaluations, a line for each run whose scores can be compared. */
function Curve({ points }: { points: Point[] }) {
  if (points.length === 0) return <div class="curve empty">F falls here while a search runs.</div>;
  const scores = points.map(({ best }) => best);
  const [low, high] = [Math.min(...scores), Math.max(...scores)];
  const last = points.at(-1)!;
  const x = (evaluations: number) => (WIDTH * evaluations) / Math.max(1, last.evaluations);
  const y = (best: number) => 6 + (HEIGHT - 12) * (1 - (best - low) / Math.max(1e-5, high - low));
  const path = points
    .map((point, index) => `${point.fresh || index === 0 ? "M" : "L"}${x(point.evaluations).toFixed(1)} ${y(point.best).toFixed(1)}`)
    .join("");
  const label = `Best F over ${last.evaluations} evaluations: from ${scores[0]!.toFixed(4)} to ${last.best.toFixed(4)}`;
  return (
    <div class="curve">
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none" role="img" aria-label={label}>
        <path class="line" d={path} />
      </svg>
      <span class="high">{high.toFixed(3)}</span>
      <span class="low">{low.toFixed(3)}</span>
      <i style={{ top: `${(100 * y(last.best)) / HEIGHT}%` }} />
    </div>
  );
}

const counted = (count: number, what: string) => `${count.toLocaleString("en")} ${what}${count === 1 ? "" : "s"}`;

const WORDS = { idle: "ready", running: "running", paused: "paused", finished: "finished" };

export function Search() {
  const now = state.value;
  const answer = progress.value;
  const running = now === "running";
  const goOn = now === "paused" ? (touched.value ? "Go on from here" : "Go on") : now === "finished" ? "Search again" : "Start";
  return (
    <section class="panel" aria-labelledby="search-title">
      <div class="panel-head">
        <h2 id="search-title">Search</h2>
        <span class="soft" data-search={now}>{WORDS[now]}{answer?.small && running ? ", small pictures" : ""}</span>
      </div>
      <Curve points={curve.value} />
      <div class="row controls">
        <IconButton
          icon={running ? "pause" : "play"}
          label={running ? "Pause the search" : `${goOn === "Start" ? "Start the search" : goOn}`}
          text={running ? "Pause" : goOn}
          keys="Space"
          class={running ? "" : "primary"}
          onClick={running ? pause : start}
        />
        <IconButton icon="step" label="Step one generation" text="Step" disabled={running} onClick={step} />
        <IconButton icon="stop" label="End the search" disabled={now === "idle" || now === "finished"} onClick={stop} />
        {answer && <span class="soft right">{counted(answer.generation, "generation")}, {counted(answer.evaluations, "rig")}</span>}
      </div>
    </section>
  );
}
