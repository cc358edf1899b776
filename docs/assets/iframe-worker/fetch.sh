#!/usr/bin/env bash
# Fetches shim.js and its licence anew: iframe-worker 1.0.4 (MIT), which lets the search of the site work on pages that are
# opened from a folder, where browsers refuse workers. Needs npm and its registry.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
npm pack --silent --pack-destination "$folder" iframe-worker@1.0.4 >/dev/null
tar -xzf "$folder"/iframe-worker-1.0.4.tgz -C "$folder"
cp "$folder/package/shim/index.js" shim.js
cp "$folder/package/LICENSE" LICENSE
