#!/usr/bin/env bash
# Installs what is missing from Debian 12's packages. Quiet and quick when nothing is missing.
#   --browser   also what the browser tests need (Chromium, Node.js, playwright-core from npm)
#   --fuzz      also what fuzzing needs (clang, its runtime)
#   --slurm     also what tests of workers in Slurm need (its daemons, munge)
#   --shared    also what tests of a shared file system need (MooseFS)
#   --dev       also linters, fuzzing runtime and inspection tools
set -euo pipefail
cd "$(dirname "$0")/.."

build=(gcc g++ libc6-dev make pkg-config libmicrohttpd-dev libuv1-dev libembree-dev libjansson-dev
       libopenexr-dev libpng-dev zlib1g-dev libturbojpeg0-dev libwebp-dev libmeshoptimizer-dev
       libdraco-dev libstb-dev libsqlite3-dev libblosc-dev libassimp-dev libgnutls28-dev
       nettle-dev libisal-dev libcurl4-gnutls-dev)
test=(libcmocka-dev curl jq libxml2-utils openexr openssl procps sqlite3)
browser=(chromium)
fuzz=(clang-14 libclang-rt-14-dev)
slurm=(slurmctld slurmd slurm-client munge)
shared=(moosefs-master moosefs-chunkserver moosefs-client)
dev=("${fuzz[@]}" clang-format clang-tidy cppcheck)

want=("${build[@]}" "${test[@]}")
with_npm=
for option in "$@"; do
    case $option in
    --browser) want+=("${browser[@]}"); with_npm=1 ;;
    --fuzz) want+=("${fuzz[@]}") ;;
    --slurm) want+=("${slurm[@]}") ;;
    --shared) want+=("${shared[@]}") ;;
    --dev) want+=("${dev[@]}") ;;
    -h | --help) sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "install-deps.sh: unknown option $option; see --help" >&2; exit 2 ;;
    esac
done
# A Node.js that is there in another way (not as a package) serves as well.
if [ -n "$with_npm" ]; then
    command -v node >/dev/null || want+=(nodejs)
    command -v npm >/dev/null || want+=(npm)
fi

have=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "${want[@]}" 2>/dev/null |
       sed -n 's/^installed //p' || true)
missing=()
for package in "${want[@]}"; do
    grep -qxF "$package" <<<"$have" || missing+=("$package")
done

if [ ${#missing[@]} -gt 0 ]; then
    as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || {
            echo "install-deps.sh: not root and no sudo; as root, run:" >&2
            echo "  apt-get install --no-install-recommends ${missing[*]}" >&2
            exit 1
        }
        as_root=(sudo)
    fi
    echo "Installing ${#missing[@]} packages: ${missing[*]}"
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
    run() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive "$@" >"$log" 2>&1 ||
            { cat "$log" >&2; echo "install-deps.sh: failed: $*" >&2; exit 1; }; }
    run apt-get update -q
    run apt-get install -y -q --no-install-recommends "${missing[@]}"
fi

if [ -n "$with_npm" ] && [ -f tests/browser/package.json ] &&
   ! cmp -s tests/browser/package-lock.json tests/browser/node_modules/.installed 2>/dev/null; then
    echo "Installing the browser tests' packages"
    (cd tests/browser && npm ci --no-audit --no-fund --ignore-scripts --loglevel=error >/dev/null &&
     cp package-lock.json node_modules/.installed)
fi
