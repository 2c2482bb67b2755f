-- Module file for Lmod. Install it as MODULEPATH/bulkley/VERSION.lua; set where `cmake --install` has put that version.
local prefix = pathJoin("/opt/bulkley", myModuleVersion())

whatis("Name: Bulkley")
whatis("Version: " .. myModuleVersion())
whatis("Description: Distributed Material Point Method solver for Herschel-Bulkley fluids and soft solids")
help([[
    bulkley --version
    bulkley run SCENE.toml

Job scripts for Slurm and PBS to copy: $BULKLEY_SCRIPTS. Scenes: $BULKLEY_SHARE/scenes.
]])

-- The MPI library that Bulkley was built with, and what else was no part of the system then.
-- depends_on("openmpi/4.1.4")
-- depends_on("petsc/3.18.5")

prepend_path("PATH", pathJoin(prefix, "bin"))  -- man finds ../share/man by it
prepend_path("CMAKE_PREFIX_PATH", prefix)
setenv("BULKLEY_SHARE", pathJoin(prefix, "share/bulkley"))
setenv("BULKLEY_SCRIPTS", pathJoin(prefix, "share/bulkley/jobs"))
