// How the picture is judged: F, its terms as bars, their weights.
import { signal } from "@preact/signals";
import { doc, opened } from "./document";
import { compared } from "./comparing";
import { judged } from "./drawing";
import { commit, edit } from "./history";
import { Icon } from "./icons";
import type { TermInfo } from "./messages";
import { interrupt } from "./searching";
import { Slider } from "./slider";
import { Targets } from "./targets";

const MOST_WEIGHT = 1;

/** Whether what terms say stands below each of them. */
const explained = signal(false);
/** Whether terms without a weight are listed. */
const all = signal(false);

function weigh(name: string, weight: number) {
  interrupt();
  edit((document) => {
    const weights = { ...document.weights, [name]: weight };
    // A picture has to be judged by something.
    return Object.values(weights).some((value) => value > 0) ? { ...document, weights } : document;
  });
}

function Term({ term }: { term: TermInfo }) {
  const value = judged.main.value?.terms[term.name];
  const other = compared.value ? judged.other.value?.terms[term.name] : undefined;
  const weight = doc.value?.weights[term.name] ?? 0;
  const said = value === undefined ? "not measured" : value.toFixed(3);
  return (
    <li class={weight > 0 ? "term" : "term off"} title={`${term.title}: ${term.meaning}`}>
      <span class="term-name">{term.title}</span>
      <span class="meter" role="img" aria-label={`${term.title} ${said}: ${term.meaning}`}>
        <i style={{ width: `${100 * (value ?? 0)}%` }} />
        {other !== undefined && <b style={{ left: `${100 * other}%` }} />}
      </span>
      <span class="number" data-term={term.name}>{value === undefined ? "–" : value.toFixed(3)}</span>
      <Slider
        bare
        label={`Weight of ${term.title}`}
        value={weight}
        least={0}
        most={MOST_WEIGHT}
        step={0.05}
        onInput={(next) => weigh(term.name, next)}
        onDone={() => commit(`Weight of ${term.title}`, `weight ${term.name}`)}
      />
      {explained.value && <p class="note">{term.meaning}</p>}
    </li>
  );
}

function Score() {
  const score = judged.main.value?.score;
  const rough = judged.main.value?.quality === 0;
  const other = compared.value ? judged.other.value?.score : undefined;
  const difference = score !== undefined && other !== undefined ? score - other : null;
  return (
    <p class="score">
      <span class="f">F{rough && " ≈"}</span>
      <output class={rough ? "rough" : ""} data-score>{score?.toFixed(4) ?? "–"}</output>
      {difference !== null && (
        <span class={difference < 0 ? "better" : "worse"}>
          {difference < 0 ? "−" : "+"}{Math.abs(difference).toFixed(4)} {difference < 0 ? "better" : "worse"}
        </span>
      )}
      {difference === null && <span class="soft">lower is better</span>}
    </p>
  );
}

export function Terms() {
  const weights = doc.value?.weights ?? {};
  const terms = opened.value?.terms ?? [];
  const shown = terms.filter(({ name }) => all.value || (weights[name] ?? 0) > 0);
  return (
    <section class="panel" aria-labelledby="terms-title">
      <div class="panel-head">
        <h2 id="terms-title">Judgement</h2>
        <button type="button" class="button" aria-pressed={explained.value} onClick={() => (explained.value = !explained.value)}>
          <Icon name="help" />
          <span>Explain</span>
        </button>
      </div>
      <Score />
      <Targets />
      <div class="columns" aria-hidden="true">
        <span>term</span>
        <span>penalty</span>
        <span>weight</span>
      </div>
      <ul class="terms">
        {shown.map((term) => <Term key={term.name} term={term} />)}
      </ul>
      <button type="button" class="link" aria-expanded={all.value} onClick={() => (all.value = !all.value)}>
        {all.value ? "Only terms with a weight" : `All ${terms.length} terms`}
      </button>
    </section>
  );
}
