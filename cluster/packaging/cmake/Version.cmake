# Writes into the build folder bulkley/version.hpp: version, compiler, flags; and git_commit.cpp, a source of the library.

# A source archive holds the commit in a file, which git filled in (.gitattributes).
set(BULKLEY_GIT_COMMIT unknown)
file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/archive_commit.txt archived_commit LIMIT_COUNT 1)
if(archived_commit MATCHES "^[0-9a-f]+$")
  set(BULKLEY_GIT_COMMIT ${archived_commit})
endif()
find_package(Git QUIET)
if(GIT_FOUND AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} describe --always --dirty --abbrev=12 --exclude=*
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE commit RESULT_VARIABLE code
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(code EQUAL 0)
    set(BULKLEY_GIT_COMMIT ${commit})
  endif()
endif()
# A new commit configures again.
if(EXISTS ${PROJECT_SOURCE_DIR}/.git/logs/HEAD)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/.git/logs/HEAD)
endif()

string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
set(BULKLEY_FLAGS "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}}")
if(BULKLEY_NATIVE)
  string(APPEND BULKLEY_FLAGS " -march=native")
endif()
if(BULKLEY_AUDIT)
  string(APPEND BULKLEY_FLAGS " -DBULKLEY_AUDIT")
endif()
if(BULKLEY_SANITIZE)
  string(APPEND BULKLEY_FLAGS " -fsanitize=address,undefined")
endif()
string(REGEX REPLACE "-f[a-z]+-prefix-map=[^ ]+" "" BULKLEY_FLAGS "${BULKLEY_FLAGS}")  # hides the build's folder; would name it
string(REGEX REPLACE "  +" " " BULKLEY_FLAGS "${BULKLEY_FLAGS}")
string(STRIP "${BULKLEY_FLAGS}" BULKLEY_FLAGS)
string(REPLACE "\\" "\\\\" BULKLEY_FLAGS "${BULKLEY_FLAGS}")
string(REPLACE "\"" "\\\"" BULKLEY_FLAGS "${BULKLEY_FLAGS}")

configure_file(${CMAKE_CURRENT_LIST_DIR}/version.hpp.in ${PROJECT_BINARY_DIR}/include/bulkley/version.hpp @ONLY)
configure_file(${CMAKE_CURRENT_LIST_DIR}/git_commit.cpp.in ${PROJECT_BINARY_DIR}/git_commit.cpp @ONLY)
