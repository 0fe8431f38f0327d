#!/usr/bin/env bash
# Builds the documentation, warnings denied. Usage: ci/docs.sh
set -euo pipefail
cd "$(dirname "$0")/.."
RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace --no-deps \
    --features faregate-tickets/critical-section,faregate-tickets/lock-api
