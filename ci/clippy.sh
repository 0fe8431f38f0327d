#!/usr/bin/env bash
# Lints everything, warnings denied. Usage: ci/clippy.sh
set -euo pipefail
cd "$(dirname "$0")/.."
cargo clippy --locked --workspace --all-targets -- -D warnings
cargo clippy --locked -p faregate-tickets -p faregate-agents --all-targets \
    --features faregate-tickets/linux,faregate-tickets/lock-api,faregate-tickets/critical-section -- -D warnings
