#!/usr/bin/env bash
# make image: the container image of both programs, by buildah or podman, whichever is there.
#   deploy/image.sh NAME [BASE]
# BASE is the Debian 12 to build on, debian:12-slim by default. "own": it is made here from Debian's packages by
# debootstrap, for machines that reach no registry (root; buildah).
set -euo pipefail
cd "$(dirname "$0")/.."
name=${1:?usage: deploy/image.sh NAME [BASE]}
base=${2:-debian:12-slim}
for tool in buildah podman; do command -v $tool >/dev/null && break || tool=; done
[ -n "$tool" ] || { echo "image.sh: neither buildah nor podman is installed: apt-get install buildah" >&2; exit 1; }
# Without systemd, user namespaces or overlays, as in a container, buildah still works so.
options=()
[ "$tool" = podman ] || options=(--isolation "${BUILDAH_ISOLATION:-chroot}")

if [ "$base" = own ]; then
    [ "$tool" = buildah ] || { echo "image.sh: a base of its own is made by buildah: apt-get install buildah" >&2; exit 1; }
    command -v debootstrap >/dev/null || { echo "image.sh: no debootstrap: apt-get install debootstrap" >&2; exit 1; }
    base=localhost/shearwater-base
    if ! buildah inspect --type image "$base" >/dev/null 2>&1; then
        root=$(mktemp -d)
        trap 'rm -rf "$root"' EXIT
        debootstrap --variant=minbase bookworm "$root/debian" >"$root/log" 2>&1 || { tail -n 5 "$root/log" >&2; exit 1; }
        container=$(buildah from scratch)
        buildah add -q "$container" "$root/debian" / >/dev/null
        buildah commit -q "$container" "$base" >/dev/null
        buildah rm "$container" >/dev/null
    fi
fi
case $tool in
buildah) buildah bud "${options[@]}" --format docker --layers --build-arg "BASE=$base" -f deploy/Containerfile -t "$name" . ;;
podman) podman build --format docker --build-arg "BASE=$base" -f deploy/Containerfile -t "$name" . ;;
esac
