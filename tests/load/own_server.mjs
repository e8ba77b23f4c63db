// A coordinator of one worker for a program that measures it; both end with the program, and leave nothing behind.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

// Its address, its process, and a folder for files, which has its data, too.
export async function ownServer(build, name, threads = 1) {
    const folder = mkdtempSync(join(tmpdir(), `${name}-`));
    const server = spawn(join(build, "shearwater"), ["serve", "--listen", "127.0.0.1:0", "--data", join(folder, "data"), "--workers", "1", "--worker-threads", String(threads)], { stdio: ["ignore", "pipe", "ignore"] });
    process.on("exit", () => {
        server.kill("SIGKILL");
        rmSync(folder, { recursive: true, force: true });
    });
    let said = "";
    const url = await new Promise((done, failed) => {
        server.stdout.on("data", (text) => { said += text; const found = /listening on (\S+)/.exec(said); if (found) done(found[1]); });
        server.once("exit", (status) => failed(new Error(`the coordinator ended with status ${status}`)));
    });
    return { url, server, folder };
}
