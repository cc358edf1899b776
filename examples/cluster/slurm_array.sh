#!/bin/bash
# casa-assets on SLURM without an engine: each task of the array works on one shard (docs/howto/scale.md).
# Submit with: sbatch slurm_array.sh SOURCES SHARDS. SOURCES and SHARDS are on a disk that all nodes share. When all
# tasks have ended: casa-assets library merge SHARDS/* --library LIBRARY. A task that was lost is submitted again by its
# number, such as: sbatch --array=7 --export=ALL,COUNT=64 slurm_array.sh SOURCES SHARDS
#SBATCH --array=1-64 --cpus-per-task=16 --mem=64G --time=24:00:00
set -euo pipefail
sources=$1 shards=$2
count=${COUNT:-$SLURM_ARRAY_TASK_COUNT}
code=0
casa-assets ingest "$sources" --shard "$SLURM_ARRAY_TASK_ID/$count" --library "$shards/$SLURM_ARRAY_TASK_ID" \
    --jobs "$SLURM_CPUS_PER_TASK" || code=$?
# 1: some inputs were rejected; 4: a person has to decide about some. The shard is finished with both.
[ "$code" = 0 ] || [ "$code" = 1 ] || [ "$code" = 4 ]
