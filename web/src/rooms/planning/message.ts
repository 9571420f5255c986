/** Messages of orbit and attitude as files. */

const LONGEST_BYTES = 8 * 1024 * 1024; // as much as the service takes

/** The file's text; null where it is longer than the service takes. */
export async function readMessage(file: File): Promise<string | null> {
  return file.size > LONGEST_BYTES ? null : file.text();
}

/** Whether a text is a CCSDS attitude message, as KVN or XML. */
export function isAem(text: string): boolean {
  return /CCSDS_AEM_VERS|<aem[\s>]/i.test(text);
}
