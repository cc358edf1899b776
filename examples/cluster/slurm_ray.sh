#!/bin/bash
# Ray on eight nodes of SLURM, and one ingest run on all of them: sbatch slurm_ray.sh
#SBATCH --nodes=8
#SBATCH --ntasks-per-node=1
#SBATCH --cpus-per-task=64
#SBATCH --mem=0
#SBATCH --time=24:00:00
set -euo pipefail
head=$(scontrol show hostnames "$SLURM_JOB_NODELIST" | head -n 1)
srun --nodes 1 --ntasks 1 --nodelist "$head" ray start --head --port 6379 --num-cpus "$SLURM_CPUS_PER_TASK" --block &
sleep 15
srun --nodes $((SLURM_JOB_NUM_NODES - 1)) --ntasks $((SLURM_JOB_NUM_NODES - 1)) --exclude "$head" \
    ray start --address "$head:6379" --num-cpus "$SLURM_CPUS_PER_TASK" --block &
sleep 15
srun --nodes 1 --ntasks 1 --nodelist "$head" --overlap \
    casa-assets ingest /shared/meshes --library /shared/library --engine ray --address "$head:6379"
