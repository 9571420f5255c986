/** The same request from a terminal and from Python. */
export function curl(service: string, request: string): string {
  const quoted = request.replace(/'/g, `'\\''`);
  return `curl -s -X POST '${service}v1/plans' \\
  -H 'Content-Type: application/json' \\
  --data-binary '${quoted}'`;
}

export function python(service: string, request: string): string {
  return `import json

import slewtrack

REQUEST = json.loads(r"""
${request}
""")

with slewtrack.Client("${service.replace(/\/$/, "")}") as client:
    plan = client.plan(REQUEST)
print(plan.id, plan.passed)
`;
}
