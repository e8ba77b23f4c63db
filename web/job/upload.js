// A file becomes an asset: hashed here, sent unless the server has it.
import { ApiError, assetUrl, hasAsset } from "../api.js";

// Browsers hash only for pages that cannot have been changed on the way.
export const canHash = () => globalThis.isSecureContext === true && Boolean(globalThis.crypto?.subtle);
export const WHY_NOT = () => `Files cannot be chosen here: this browser hashes files only for pages from https, 127.0.0.1 or localhost, ` +
  `and this page came from ${location.origin}. Open it at http://127.0.0.1${location.port ? `:${location.port}` : ""} on the server's machine, ` +
  `upload the file with “shearwater submit”, or give the digest of a file that the server has.`;

const hex = (bytes) => [...new Uint8Array(bytes)].map((byte) => byte.toString(16).padStart(2, "0")).join("");

// The SHA-256 of a file that is an asset now. onProgress("hashing" or "sending", share sent).
export async function upload(file, onProgress) {
  onProgress("hashing", 0);
  const sha256 = hex(await crypto.subtle.digest("SHA-256", await file.arrayBuffer()));
  if (!await hasAsset(sha256)) await send(file, sha256, (share) => onProgress("sending", share));
  return sha256;
}

// fetch does not tell how much has gone out.
function send(file, sha256, onShare) {
  return new Promise((done, fail) => {
    const request = new XMLHttpRequest();
    request.open("PUT", assetUrl(sha256));
    request.setRequestHeader("Content-Type", "application/octet-stream");
    request.upload.addEventListener("progress", ({ loaded, total }) => onShare(total ? loaded / total : 0));
    request.addEventListener("error", () => fail(new Error("the connection broke off; choose the file again")));
    request.addEventListener("load", () => {
      if (request.status < 300) return done();
      let problem = null;
      try { problem = JSON.parse(request.responseText); } catch { /* told by the status */ }
      fail(new ApiError(request.status, problem));
    });
    request.send(file);
  });
}
