#!/usr/bin/env bash
# The load test, small and with loose bounds: that each of its parts works and measures. Quotas are whole.
#   tests/system/load.sh BUILD_DIR
cd "$(dirname "$0")/../.." && exec node tests/load/load.mjs "${1:?usage: tests/system/load.sh BUILD_DIR}" \
    fair_s=8 fair_jobs=60 fair_within=0.1 quota_jobs=20 queue_jobs=1000 queue_pages=100 submit_min=100 page_p99_ms=100 \
    watch_viewers=200 watch_feeds=24 watch_stuck=3 watch_pairs=1 watch_spp=40 watch_width=640 watch_height=360 watch_share=1 watch_feed_rate=0 \
    watch_slower=0.5 watch_poke_ms=500 event_p99_ms=5000
