/** The passes with looks, in order of time, each with its plan. */
import { words } from "../../i18n";
import { period } from "../../i18n/forms";
import { Link } from "../../parts/Link";
import { type Campaign, scanTold } from "./campaign";

export function Passes({ passes }: { passes: Campaign["passes"] }) {
  const text = words.value.campaigns;
  return (
    <section class="panel" aria-labelledby="campaign-passes">
      <h2 id="campaign-passes">
        {text.passes} <span class="count">{passes.length}</span>
      </h2>
      <div class="scroll-x" tabIndex={0} role="group" aria-label={text.passes}>
        <table>
          <thead>
            <tr>
              <th scope="col" class="number">
                {text.columns.pass}
              </th>
              <th scope="col">{text.columns.times}</th>
              <th scope="col">{text.columns.state}</th>
              <th scope="col">{text.columns.looks}</th>
              <th scope="col">{text.columns.plan}</th>
            </tr>
          </thead>
          <tbody>
            {passes.map((one) => (
              <tr key={one.number}>
                <td class="number">{one.number + 1}</td>
                <td class="mono nowrap">{period(one.start, one.stop).replace(" UTC", "")}</td>
                <td>
                  <span class={`pass-state pass-${one.state}`}>{words.value.shell.states[one.state]}</span>
                </td>
                <td>
                  {"carrier" in one && <b>{one.carrier} </b>}
                  {one.looks.map((look) => `${look.target} ${scanTold(look)}`.trim()).join(", ") || "–"}
                  {one.problem && <div class="small">{words.value.service.told(one.problem.detail)}</div>}
                  {one.left_out.map((look) => (
                    <div key={look.target} class="small">
                      {text.without(look.target, words.value.service.told(look.because))}
                    </div>
                  ))}
                </td>
                <td>
                  <Link to={`/plans/${one.plan}`}>{text.toPlan(one.number + 1)}</Link>
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
