#!/usr/bin/env bash
# A measured material goes with its scene: submit uploads its file, the importer says how well lobes fit it, and both
# ways to render give the same light. A file that ends early refuses the job with its place.
#   tests/system/measured.sh BUILD_DIR
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/measured.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash

# A white Lambert surface of albedo 1/2 as MERL would have it, 24 x 16 x 16 bins, under a sky of 1.
make_scene() {
    node -e '
        const fs = require("fs"), [dir] = process.argv.slice(1), bins = [24, 16, 16], all = 24 * 16 * 16;
        const floor = new Float32Array([-9, 0, -9, -9, 0, 9, 9, 0, -9, 9, 0, 9]);
        fs.writeFileSync(`${dir}/my paint.binary`, Buffer.concat([Buffer.from(Int32Array.from(bins).buffer),
            ...[1500, 1500 / 1.15, 1500 / 1.66].map((s) => Buffer.from(new Float64Array(all).fill(0.5 / Math.PI * s).buffer))]));
        fs.writeFileSync(`${dir}/floor.bin`, Buffer.concat([Buffer.from(floor.buffer), Buffer.from(Uint16Array.from([0, 1, 2, 2, 1, 3]).buffer)]));
        fs.writeFileSync(`${dir}/floor.gltf`, JSON.stringify({ asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
            materials: [{ extras: { shearwater: { model: "measured", uri: "my%20paint.binary" } } }], buffers: [{ byteLength: 60, uri: "floor.bin" }],
            bufferViews: [{ buffer: 0, byteLength: 48 }, { buffer: 0, byteOffset: 48, byteLength: 12 }],
            accessors: [{ bufferView: 0, componentType: 5126, count: 4, type: "VEC3", min: [-9, 0, -9], max: [9, 0, 9] },
                { bufferView: 1, componentType: 5123, count: 6, type: "SCALAR" }],
            meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, material: 0 }] }] }));' "$tmp" &&
        echo '{"scene": {"file": "floor.gltf", "camera": {"eye": [0, 3, 2], "target": [0, 0, 0]}}, "image": {"width": 32, "height": 32},
            "environment": {"radiance": [1, 1, 1]}, "sampling": {"spp": 64}}' >"$tmp/job.json"
}
half_bright() { "$build/shearwater" compare "$1" "$1" | jq -e '.finite and (.mean_test | all(. > 0.47 and . < 0.53))'; }
same_bytes() { "$build/shearwater" compare "$tmp/here.exr" "$tmp/there.exr" | jq -e '.rmse == 0'; }
there() {
    id=$("$build/shearwater" submit "$tmp/job.json" --server "$url" --quiet) && await_state "$id" finished 60 &&
        curl -sSf --noproxy '*' -o "$tmp/there.exr" "$url/v1/jobs/$id/frames/1/image.exr"
}
ends_early() {
    truncate -s 5000 "$tmp/my paint.binary"
    ! "$build/shearwater" render "$tmp/job.json" --quiet -o "$tmp/none.exr" 2>"$tmp/said" &&
        grep -q 'materials\[0\].extras.shearwater.uri.*only 5000 are there' "$tmp/said"
}

check "a measured surface is made" make_scene
check "it renders here" bash -c "'$build/shearwater' render '$tmp/job.json' -o '$tmp/here.exr' 2>&1 | tee '$tmp/said' >/dev/null && [ -s '$tmp/here.exr' ]"
check "a warning tells how well lobes fit" grep -q 'extras.shearwater.uri: the measurement is fitted by .* % of its light elsewhere' "$tmp/said"
check "it is as bright as was measured" half_bright "$tmp/here.exr"
serve_start "$tmp/data" --workers 1 --worker-threads 1
check "submit brings its file along" there
check "the picture is the same" same_bytes
check "a file that ends early refuses the scene with its place" ends_early
tap_done
