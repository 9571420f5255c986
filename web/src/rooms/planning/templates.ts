/** Requests kept in the browser by names, to begin others with. */
import { signal } from "@preact/signals";

import { isMembers } from "../../parts/fields/shape";
import { type Conditions, type DraftRequest, requestOf } from "./draft";

export interface Template {
  name: string;
  request: DraftRequest;
  conditions: Conditions;
}

const KEPT = "slewtrack.templates";

function readTemplates(): Template[] {
  const read: unknown = JSON.parse(localStorage.getItem(KEPT) ?? "[]");
  if (!Array.isArray(read)) return [];
  return (read as unknown[]).filter((one): one is Template => isMembers(one) && requestOf(one.request) !== null);
}

export const templates = signal<readonly Template[]>(readTemplates());

/** In place of one of the same name; raises DOMException where the browser has no room for it. */
export function saveTemplate(template: Template): void {
  keep([...templates.value.filter((one) => one.name !== template.name), template]);
}

export function deleteTemplate(name: string): void {
  keep(templates.value.filter((one) => one.name !== name));
}

function keep(next: readonly Template[]): void {
  localStorage.setItem(KEPT, JSON.stringify(next));
  templates.value = next;
}
