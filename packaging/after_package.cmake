# Read by cpack when it has made packages, which dpkg-deb then packs anew: by xz -9, whose window reaches from one tool to
# the next, and in a third of the size, as all tools hold the same library; and without the scripts by which cpack has
# ldconfig called for any file below lib/, minimizer.so being no library that others link.
foreach(package IN LISTS CPACK_PACKAGE_FILES)
  set(folder ${package}.contents)
  file(REMOVE_RECURSE ${folder})
  execute_process(COMMAND dpkg-deb --raw-extract ${package} ${folder} COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE ${folder}/DEBIAN/postinst ${folder}/DEBIAN/postrm)
  execute_process(COMMAND dpkg-deb --root-owner-group ${CPACK_LEEWAY_COMPRESSION} --build ${folder} ${package}
                  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE_RECURSE ${folder})
endforeach()
