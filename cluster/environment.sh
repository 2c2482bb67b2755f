# Settings for Open MPI on a workstation or in a container; source it before mpirun: `. cluster/environment.sh`.
# On a cluster the batch system places the ranks: do not source it there.

if [ "$(id -u)" -eq 0 ]; then  # Open MPI refuses to run as root unless told twice
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi
# More ranks than cores (Open MPI 4, then 5).
export OMPI_MCA_rmaps_base_oversubscribe=1 PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
# No binding: two small runs at the same time would otherwise share core 0.
export OMPI_MCA_hwloc_base_binding_policy=none PRTE_MCA_hwloc_default_binding_policy=none
# Containers often forbid reading another process's memory.
export OMPI_MCA_btl_vader_single_copy_mechanism=none
# Shared memory and TCP, by name: the libraries for InfiniBand and Omni-Path wait 0.2 s for hardware before every start.
export OMPI_MCA_pml="${OMPI_MCA_pml:-ob1}"
# hwloc must not look for GPUs through X servers: one that ends at that moment takes mpirun or a rank with it.
export HWLOC_COMPONENTS="${HWLOC_COMPONENTS:--gl}"
# One thread per rank.
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
