#!/usr/bin/env bash
# Checks the format. Usage: ci/fmt.sh
set -euo pipefail
cd "$(dirname "$0")/.."
cargo fmt --all -- --check
