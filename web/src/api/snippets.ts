/** The same request from a terminal and from Python. */
export function curl(service: string, request: string, path = "v1/plans"): string {
  const quoted = request.replace(/'/g, `'\\''`);
  return `curl -s -X POST '${service}${path}' \\
  -H 'Content-Type: application/json' \\
  --data-binary '${quoted}'`;
}

/** call: of the client, for what is asked. */
export function python(service: string, request: string, call = "plan"): string {
  return `import json

import slewtrack

REQUEST = json.loads(r"""
${request}
""")

with slewtrack.Client("${service.replace(/\/$/, "")}") as client:
    plan = client.${call}(REQUEST)
print(plan.id, plan.passed)
`;
}
