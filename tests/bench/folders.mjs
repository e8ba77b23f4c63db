// Where the bench finds what is not in the repository.
import { existsSync } from "node:fs";
import { resolve } from "node:path";

export const scenesFolder = () => resolve(process.env.SHEARWATER_SCENES ?? "scenes");

// Scenes with two references each, and what others' denoisers make of them; beside the scenes unless it is said.
export const peersFolder = (given) => resolve(given ?? process.env.SHEARWATER_PEERS ?? `${scenesFolder()}/../peers`);

// Trained weights of Open Image Denoise (make peer-weights); null where there are none.
export function weightsFile(build, given) {
  const path = resolve(given ?? process.env.SHEARWATER_PEER_WEIGHTS ?? `${build}/peer/rt_hdr_alb_nrm.tza`);
  return existsSync(path) ? path : null;
}
