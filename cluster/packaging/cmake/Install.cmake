# The files that `cmake --install` installs; docs/install.md lists them. All paths between them are relative, so that the whole
# prefix may be moved.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# --- the program, the scenes, the scripts -----------------------------------------------------------------------------------
install(TARGETS bulkley_program)
install(DIRECTORY drivers/scenes drivers/paraview DESTINATION ${CMAKE_INSTALL_DATADIR}/bulkley
        PATTERN __pycache__ EXCLUDE)
install(DIRECTORY drivers/python DESTINATION ${CMAKE_INSTALL_DATADIR}/bulkley
        PATTERN __pycache__ EXCLUDE PATTERN "*.egg-info" EXCLUDE PATTERN build EXCLUDE)
# Job scripts read job_functions.sh in the parent of their folders: the variable BULKLEY_SCRIPTS of the module file.
install(DIRECTORY cluster/jobs/slurm cluster/jobs/pbs cluster/packaging/modulefiles DESTINATION ${CMAKE_INSTALL_DATADIR}/bulkley/jobs
        USE_SOURCE_PERMISSIONS)
install(FILES cluster/jobs/job_functions.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/bulkley/jobs)
install(FILES LICENSE CITATION.cff CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES docs/bulkley.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES cluster/packaging/completion/bulkley.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME bulkley)
install(FILES cluster/packaging/completion/_bulkley DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)

# --- the library, for programs with laws and drivers of their own -----------------------------------------------------------
set_target_properties(bulkley_options PROPERTIES EXPORT_NAME options)
set_target_properties(bulkley_core PROPERTIES EXPORT_NAME core)
set_target_properties(bulkley_driver PROPERTIES EXPORT_NAME driver)
install(TARGETS bulkley_options bulkley_core bulkley bulkley_driver EXPORT bulkleyTargets
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY include/bulkley DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES ${PROJECT_BINARY_DIR}/include/bulkley/version.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/bulkley)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/bulkley)
install(EXPORT bulkleyTargets NAMESPACE bulkley:: DESTINATION ${package_folder})
configure_package_config_file(cluster/packaging/cmake/bulkleyConfig.cmake.in ${PROJECT_BINARY_DIR}/bulkleyConfig.cmake
                              INSTALL_DESTINATION ${package_folder} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/bulkleyConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/bulkleyConfig.cmake ${PROJECT_BINARY_DIR}/bulkleyConfigVersion.cmake
              cluster/packaging/cmake/BulkleyDependencies.cmake DESTINATION ${package_folder})
