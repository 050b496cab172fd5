// The history as a list: each step can be gone to.
import { cursor, entries, jump } from "./history";
import { interrupt } from "./searching";

export function Steps() {
  const all = entries.value;
  const now = cursor.value;
  return (
    <section class="panel" aria-labelledby="steps-title">
      <div class="panel-head">
        <h2 id="steps-title">History</h2>
        <span class="soft">{now + 1} of {all.length}</span>
      </div>
      <ol class="steps" reversed>
        {all.map((entry, index) => (
          <li key={index}>
            <button
              type="button"
              class={index > now ? "undone" : ""}
              aria-current={index === now ? "step" : undefined}
              onClick={() => {
                interrupt();
                jump(index);
              }}
            >
              <span>{entry.label}</span>
              <span class="number">{entry.score?.toFixed(4) ?? ""}</span>
            </button>
          </li>
        )).reverse()}
      </ol>
    </section>
  );
}
