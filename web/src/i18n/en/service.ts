/** Texts of the service: its own language. */
export const service = { told: (text: string): string => text };
