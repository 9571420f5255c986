/** Two plans side by side: every figure, and which of them differ. */
import { get } from "../../api/client";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { labelOf } from "../../i18n/labels";
import { Link } from "../../parts/Link";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { type Figure, figures, type Plan } from "./figures";

export function Compared({ ids }: { ids: [string, string] }) {
  const text = words.value;
  const { answer: plans, error } = useRequest(ids.join(), async (until) => {
    const answers = await Promise.all(ids.map((id) => get("/v1/plans/{id}", { id, signal: until })));
    return answers.filter((answer): answer is Plan => "table" in answer);
  });
  if (error !== null) return <ProblemNotice error={error} />;
  if (!plans) return <p class="loading">{text.shell.loading}</p>;
  const [first, second] = plans;
  if (!first || !second) return <p>{text.library.notDone}</p>;
  const rows = side(figures(first), figures(second));
  const differing = rows.filter((row) => row.differs).length;
  return (
    <>
      <p>
        {differing ? text.library.differing(differing, rows.length) : text.library.same}{" "}
        <Link to="/plans">{text.library.back}</Link>
      </p>
      <div class="scroll-x" tabIndex={0} role="region" aria-label={text.library.compared}>
        <table class="compared">
          <thead>
            <tr>
              <th scope="col">{text.library.figure}</th>
              {[first, second].map((plan) => (
                <th key={plan.id} scope="col">
                  <Link to={`/plans/${plan.id}`}>
                    {labelOf({ ...plan.summary, id: plan.id })} ({text.library.revision(plan.revision)})
                  </Link>
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {rows.map(({ name, values, differs }) => (
              <tr key={name} class={differs ? "differs" : undefined}>
                <th scope="row">
                  {name}
                  {differs && <span class="hidden"> ({text.library.differs})</span>}
                </th>
                <td>{values[0]}</td>
                <td>{values[1]}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}

interface Row {
  name: string;
  values: [string, string];
  differs: boolean;
}

/** What only one of them has stands beside a dash. */
function side(first: Figure[], second: Figure[]): Row[] {
  const names = [...new Set([...first, ...second].map((figure) => figure.name))];
  const value = (of: Figure[], name: string) => of.find((figure) => figure.name === name)?.value ?? "–";
  return names.map((name) => {
    const values: [string, string] = [value(first, name), value(second, name)];
    return { name, values, differs: values[0] !== values[1] };
  });
}
