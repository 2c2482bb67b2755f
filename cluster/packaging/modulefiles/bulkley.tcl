#%Module1.0
# Module file for Environment Modules. Install it as MODULEPATH/bulkley/VERSION; set where `cmake --install` has put that
# version.
set version [file tail [module-info name]]
set prefix /opt/bulkley/$version

module-whatis "Bulkley $version: distributed Material Point Method solver for Herschel-Bulkley fluids and soft solids"
proc ModulesHelp {} {
    puts stderr "    bulkley --version"
    puts stderr "    bulkley run SCENE.toml"
    puts stderr "Job scripts for Slurm and PBS to copy: \$BULKLEY_SCRIPTS. Scenes: \$BULKLEY_SHARE/scenes."
}
conflict bulkley

# The MPI library that Bulkley was built with, and what else was no part of the system then.
# prereq openmpi/4.1.4
# prereq petsc/3.18.5

prepend-path PATH $prefix/bin  ;# man finds ../share/man by it
prepend-path CMAKE_PREFIX_PATH $prefix
setenv BULKLEY_SHARE $prefix/share/bulkley
setenv BULKLEY_SCRIPTS $prefix/share/bulkley/jobs
