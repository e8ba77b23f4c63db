// Where the bench finds what is not in the repository.
import { resolve } from "node:path";

export const scenesFolder = () => resolve(process.env.SHEARWATER_SCENES ?? "scenes");

// Scenes with two references each, and what others' denoisers make of them; beside the scenes unless it is said.
export const peersFolder = (given) => resolve(given ?? process.env.SHEARWATER_PEERS ?? `${scenesFolder()}/../peers`);
