#!/usr/bin/env bash
# The units of deploy/systemd on a Debian that boots: in a container of systemd-nspawn, without a network, as root.
#   tests/deploy/boot.sh BUILD_DIR [ROOT]
# ROOT is made with debootstrap where there is none (minutes, some 500 MB); default: BUILD_DIR/boot-root.
# TAP on standard output; all that was said is in ROOT/root/said.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/deploy/boot.sh BUILD_DIR [ROOT]}
root=${2:-$build/boot-root}
. tests/tap.bash
bail() { echo "Bail out! $*"; exit 1; }
[ "$(id -u)" = 0 ] || bail "systemd-nspawn wants root"
for tool in debootstrap systemd-nspawn; do
    command -v $tool >/dev/null || bail "no $tool: apt-get install debootstrap systemd-container"
done

# What the programs need, and no tool more than Debian's smallest system has.
mapfile -t libraries <deploy/runtime-packages
if [ ! -e "$root/etc/debian_version" ]; then
    echo "# making $root" >&2
    debootstrap --variant=minbase --include=systemd,systemd-sysv,curl,jq bookworm "$root" >"$root.log" 2>&1 ||
        bail "debootstrap failed: $root.log"
    chroot "$root" sh -c "apt-get update -q && apt-get install -y -q --no-install-recommends ${libraries[*]}" >>"$root.log" 2>&1 ||
        bail "the libraries could not be installed: $root.log"
fi
check "the programs and units are installed" make -s install B="$build" DESTDIR="$(realpath "$root")" PREFIX=/usr
find "$root/etc/systemd/system" -name 'boot-check*' -delete
rm -rf "$root"/var/lib/private/shearwater "$root"/root/{said,results}

mkdir -p "$root/etc/shearwater" "$root/etc/systemd/system/shearwater.service.d"
(umask 077; head -c 32 /dev/urandom | od -An -tx1 | tr -d ' \n' >"$root/etc/shearwater/worker.key")
printf '[Service]\nLoadCredential=worker.key:/etc/shearwater/worker.key\n' \
    >"$root/etc/systemd/system/shearwater.service.d/key.conf"
echo 'SHEARWATER_OPTIONS="--workers 1 --worker-listen 127.0.0.1:8041 --worker-key /run/credentials/shearwater.service/worker.key"' \
    >"$root/etc/default/shearwater"
cp tests/scenes/cornell-box/cornell-box.glb tests/deploy/boot_inside.sh "$root/root/"
cat >"$root/etc/systemd/system/boot-check.service" <<'U'
[Unit]
After=multi-user.target
[Service]
Type=oneshot
ExecStart=/bin/bash /root/boot_inside.sh
U
mkdir -p "$root/etc/systemd/system/multi-user.target.wants"
ln -sf ../boot-check.service "$root/etc/systemd/system/multi-user.target.wants/boot-check.service"
check "it boots, and comes to its end" timeout 240 systemd-nspawn -q -D "$root" -b --private-network \
    --register=no --keep-unit -M "shearwater-boot-$$" </dev/null
while IFS=$'\t' read -r result text; do check "$text" [ "$result" = 0 ]; done <"$root/root/results"
check "all was tried" grep -q "the end" "$root/root/said"
tap_done
