/** The viewer, which is loaded when a plan is first looked at. */
import { part } from "../../api/part";
import { NoAnswer } from "../../api/problem";
import { useRequest } from "../../api/request";

export function useViewer() {
  return useRequest("viewer", async () => {
    try {
      return (await part(() => import("./Viewer"))).default;
    } catch (caught) {
      throw new NoAnswer(String(caught));
    }
  });
}
