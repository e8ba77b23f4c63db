#!/usr/bin/env bash
# deploy/kubernetes: the manifests against the schemas of Kubernetes and KEDA, and the programs' own options; and what
# scales by /v1/stats, with processes for pods: a burst of jobs brings workers from none to some and back, killed ones
# are replaced, and nothing is lost.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${1:?usage: tests/system/kubernetes.sh BUILD_DIR}
. tests/tap.bash
. tests/system/jobs.bash
judge() { node tests/deploy/kubernetes/check.mjs "$@"; }

# ---- the manifests ----
if [ -d tests/browser/node_modules/kubernetes-models ]; then
    for overlay in base keda hpa; do check "$overlay is in order" judge deploy/kubernetes/$overlay; done
    has() { judge "deploy/kubernetes/$1" | grep -qx "$2"; }
    check "keda scales the workers" has keda 'ScaledObject worker'
    check "hpa, too" has hpa 'HorizontalPodAutoscaler worker'
    # refuses WHAT SED-SCRIPT FILE WORDS: a copy that sed has spoilt
    refuses() {
        rm -rf "$tmp/kubernetes"; cp -r deploy/kubernetes "$tmp/kubernetes"
        sed -i "$1" "$tmp/kubernetes/$2"
        ! cmp -s "deploy/kubernetes/$2" "$tmp/kubernetes/$2" || { echo "nothing was spoilt"; return 1; }
        ! judge "$tmp/kubernetes/keda" >"$tmp/said" && grep -q -- "$3" "$tmp/said" || { cat "$tmp/said"; return 1; }
    }
    check "an unknown field is refused" refuses 's/readOnlyRootFilesystem/readonlyRootFilesystem/' base/workers.yaml 'readonlyRootFilesystem is no field'
    check "... of KEDA's, too" refuses 's/cooldownPeriod/coolDownPeriod/' keda/scaler.yaml 'coolDownPeriod is no field'
    check "a missing field is refused" refuses '/^  selector: /d' base/workers.yaml 'required property selector'
    check "a value of another type is refused" refuses 's/replicas: 1/replicas: one/' base/coordinator.yaml 'replicas'
    check "a volume that is not there is refused" refuses 's/{name: cache, mountPath/{name: cash, mountPath/' base/workers.yaml 'no volume cash'
    check "a selector that selects nothing is refused" refuses 's/component: worker/component: workers/' base/policies.yaml 'selects no pod'
    check "a root that can be written is refused" refuses '/readOnlyRootFilesystem/d' base/workers.yaml 'root can be written'
    check "a Secret that others may read is refused" refuses 's/0440/0444/' base/workers.yaml 'others may read'
    check "two that say how many workers there are are refused" refuses 's/^  selector: {matchLabels: \*labels}/  replicas: 3\n&/' base/workers.yaml 'so does a scaler'
    if kubectl version --client >"$tmp/kubectl" 2>&1 && ! grep -q 'Kustomize Version: v[1-3]' "$tmp/kubectl"; then
        same() { kubectl kustomize "deploy/kubernetes/$1" >"$tmp/made.yaml" && diff <(judge "$tmp/made.yaml") <(judge "deploy/kubernetes/$1"); }
        for overlay in base keda hpa; do check "kustomize makes the same of $overlay" same $overlay; done
    else
        skip "kustomize makes the same" "kubectl is not installed"
    fi
else
    skip "the manifests are in order" "needs node and kubernetes-models: make deps-browser"
fi
# known COMMAND... < OPTIONS: each is one of its options
known() { local option help; help=$("$@" --help); while read -r option; do grep -qE -- "$option( |\$)" <<<"$help" || { echo "$option is no option of $*"; return 1; }; done; }
options_of() { sed -nE 's/^ +- (--[a-z-]+).*/\1/p' "deploy/kubernetes/base/$1"; }
check "the coordinator's options are its own" known "$build/shearwater" serve < <(options_of coordinator.yaml)
check "so are the workers'" known "$build/shearwater-worker" < <(options_of workers.yaml)
check "... and they are some" [ "$(options_of workers.yaml | wc -l)" -ge 5 ]

# ---- the scaler ----
serve_start "$tmp/data" --workers 0 || { echo "Bail out! no server"; exit 1; }
scaler=
scale() { # scale LOG WORDS...
    node tests/deploy/kubernetes/scaler.mjs "$url" threads=1 "${@:2}" -- "$build/shearwater-worker" --connect "unix:$tmp/data/worker.sock" \
        --threads 1 --cache "$tmp/cache" --quiet >"$tmp/$1.log" 2>"$tmp/$1.err" &
    scaler=$!
    track $scaler
}
box() { echo "\"image\": {\"width\": $1, \"height\": $1}, \"sampling\": {\"spp\": $2, \"tile_px\": 16}, \"filter\": {\"method\": \"none\"}"; }
wanted() { is "$(http "$url/v1/stats" | jq .threads_wanted)" "$1"; }
started() { grep -c started "$tmp/$1.log"; }
nobody() { [ "$(http "$url/v1/stats" | jq .workers)" = 0 ] && [ "$(started "$1")" -gt 0 ] && [ "$(started "$1")" = "$(grep -c ended "$tmp/$1.log")" ]; }

scale burst most=3 cooldown_s=2
sleep 1
check "without a job there is no worker" is "$(started burst)" 0
id=$(submit "$(box 64 4)")
check "the first tile comes within 10 s" eventually 10 has_landed "$id" 1
ids=("$id")
for _ in 1 2 3 4 5; do ids+=("$(submit "$(box 128 64)")"); done
all_start() { [ "$(http "$url/v1/stats" | jq .workers)" -ge 3 ]; }
check "a burst brings up as many as may be" eventually 20 all_start
for id in "${ids[@]}"; do check "job $id is done" await_state "$id" finished 120; done
check "then no thread is wanted" wanted 0
check "... and all workers go" eventually 20 nobody burst
check "... in order" bash -c "! grep ended '$tmp/burst.log' | grep -v 'ended 0,'"
exr "${ids[5]}" "$tmp/scaled.exr"
kill $scaler; wait $scaler 2>/dev/null
"$build/shearwater" render "$tmp/job.json" --quiet -o "$tmp/alone.exr"
check "the bytes are those of one worker" cmp "$tmp/alone.exr" "$tmp/scaled.exr"

# A thousand tiles, while a tenth of the workers (here one) is killed every second, whatever it holds then.
scale killed most=4 cooldown_s=2 kill_s=1
id=$(submit "$(box 512 40)")
check "a thousand tiles are done though workers are killed" await_state "$id" finished 240
check "... which they were" bash -c "[ \$(grep -c SIGKILL '$tmp/killed.log') -ge 2 ]"
check "... while they held tiles" shows "$id" '.statistics.tiles.reissued > 0'
check "no tile is lost" shows "$id" '.progress.tiles_done == .progress.tiles_total and .progress.tiles_total >= 1000'
exr "$id" "$tmp/killed.exr"
check "all workers go" eventually 20 nobody killed
kill $scaler; wait $scaler 2>/dev/null
"$build/shearwater" render "$tmp/job.json" --quiet -o "$tmp/alone.exr"
check "the bytes are those of an undisturbed farm" cmp "$tmp/alone.exr" "$tmp/killed.exr"
tap_done
