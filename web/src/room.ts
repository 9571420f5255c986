/** The attributes of every room. */
export interface RoomProps {
  /** Of what the address names: of "/plans/:id" the id. */
  params: Record<string, string>;
}
