/** One plan: its verdict, what it looks like, what can be taken away. */
import { useEffect, useState } from "preact/hooks";
import { lazy, Suspense } from "preact/compat";

import { url } from "../../api/client";
import { words } from "../../i18n";
import { ProblemNotice } from "../../parts/ProblemNotice";
import type { RoomProps } from "../../rooms";
import { fetchPlan, isPlan, type Plan } from "./plan";

const Look = lazy(() => import("../look/Look"));

export default function PlanRoom({ params }: RoomProps) {
  const id = params.id ?? "";
  const text = words.value;
  const [plan, setPlan] = useState<Plan | null>(null);
  const [error, setError] = useState<unknown>(null);
  useEffect(() => {
    const wanted = new AbortController();
    fetchPlan(id, wanted.signal).then(
      (answer) => isPlan(answer) && setPlan(answer),
      (caught: unknown) => !wanted.signal.aborted && setError(caught),
    );
    return () => wanted.abort();
  }, [id]);
  if (error !== null) return <ProblemNotice error={error} />;
  if (!plan) return <p class="loading">{text.shell.loading}</p>;
  return (
    <div class="room">
      <h1>{plan.summary.name}</h1>
      <p data-testid="verdict">{plan.verification.passed ? text.plan.passed : text.plan.failed}</p>
      <a role="button" class="button" download href={url("/v1/plans/{id}/table", { id, query: { format: "csv" } })}>
        {text.plan.csv}
      </a>
      <Suspense fallback={<p class="loading">{text.shell.loading}</p>}>
        <Look plan={plan} />
      </Suspense>
    </div>
  );
}
