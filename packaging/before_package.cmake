# Read by cpack before it begins.
foreach(tool dpkg-shlibdeps file help2man)
  find_program(LEEWAY_FOUND_${tool} ${tool})
  if(NOT LEEWAY_FOUND_${tool})  # without the first, cpack would make a package that depends on nothing
    message(FATAL_ERROR "no '${tool}' here, which a package needs: scripts/install-dependencies installs it")
  endif()
endforeach()

# Files, man pages and changelog bear the date of the last commit, not that of the day: equal commits give equal packages.
if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  execute_process(COMMAND git log -1 --format=%ct WORKING_DIRECTORY ${CPACK_LEEWAY_SOURCE_FOLDER} OUTPUT_VARIABLE date
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT date)  # no repository
    file(TIMESTAMP ${CPACK_LEEWAY_SOURCE_FOLDER}/CHANGELOG.md date "%s" UTC)
  endif()
  set(ENV{SOURCE_DATE_EPOCH} ${date})
endif()
