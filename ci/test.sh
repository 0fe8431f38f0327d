#!/usr/bin/env bash
# Runs the README's test command, and the tests that need a feature.
# With CI set, a test that lacks a right it needs fails instead of skipping.
# Usage: ci/test.sh
set -euo pipefail
cd "$(dirname "$0")/.."
cargo test --workspace
# The locks under every strategy, those of other targets included, and tickets' own ways.
cargo test --locked -p faregate-tickets --features linux,lock-api,critical-section \
    --test locks --test ways
