# What a packager expects beside libraries and headers: pkg-config files, man pages, completions, documentation; and one
# clear message where something of it is not built yet.

# Where shared components are installed, the programs find them from where they are themselves.
if(BUILD_SHARED_LIBS)
  file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_BINDIR} /prefix/${CMAKE_INSTALL_LIBDIR})
  set(CMAKE_INSTALL_RPATH $ORIGIN $ORIGIN/${up})
endif()

# What a component links, as pkg-config names it: a module that is required, or a library.
set(AFFERENT_PKG_protobuf::libprotobuf protobuf)
set(AFFERENT_PKG_TBB::tbb tbb)
set(AFFERENT_PKG_OpenSSL::SSL libssl libcrypto)
set(AFFERENT_PKG_hwy::hwy libhwy)
set(AFFERENT_PKG_hwy::hwy_contrib libhwy-contrib)
set(AFFERENT_PKG_MPI::MPI_CXX ompi-c)
set(AFFERENT_LIB_Threads::Threads -pthread)

# afferent_pkg_config(<component> LIBRARY <name> DESCRIPTION <text> [NAME <module>] [PUBLIC <target>...]
#   [PRIVATE <target>...]): the module afferent-<component>. Static libraries need of their users all that they link.
function(afferent_pkg_config component)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LIBRARY;DESCRIPTION;NAME" "PUBLIC;PRIVATE")
  set(module afferent-${component})
  if(arg_NAME)
    set(module ${arg_NAME})
  endif()
  set(links "")
  foreach(kind PUBLIC PRIVATE)
    set(requires_${kind} "")
    set(libs_${kind} "")
    foreach(dependency IN LISTS arg_${kind})
      if(dependency MATCHES "^afferent::(.+)$")
        list(APPEND requires_${kind} "afferent-${CMAKE_MATCH_1} = ${PROJECT_VERSION}")
      elseif(dependency MATCHES "BUILD_INTERFACE|^Boost::headers$")
        # Headers alone, found where the compiler looks.
      elseif(DEFINED AFFERENT_PKG_${dependency})
        list(APPEND requires_${kind} ${AFFERENT_PKG_${dependency}})
        list(TRANSFORM AFFERENT_PKG_${dependency} REPLACE "^lib" "" OUTPUT_VARIABLE libraries)
        list(APPEND links ${libraries})
      elseif(DEFINED AFFERENT_LIB_${dependency})
        list(APPEND libs_${kind} ${AFFERENT_LIB_${dependency}})
        list(APPEND links pthread)
      elseif(dependency MATCHES "^[a-z0-9_]+$")
        list(APPEND libs_${kind} -l${dependency})
        list(APPEND links ${dependency})
      else()
        message(FATAL_ERROR "cmake/packaging.cmake does not know what pkg-config calls ${dependency}")
      endif()
    endforeach()
  endforeach()
  string(REPLACE "-" "_" links "${links}")
  set(AFFERENT_${component}_LINKS "${links}" CACHE INTERNAL "")

  set(text "")
  if(BUILD_SHARED_LIBS)
    list(JOIN requires_PUBLIC ", " requires)
    list(JOIN requires_PRIVATE ", " requires_private)
    list(JOIN libs_PUBLIC " " libs)
    list(JOIN libs_PRIVATE " " libs_private)
  else()
    list(JOIN requires_PUBLIC ", " requires)
    set(requires ${requires_PUBLIC} ${requires_PRIVATE})
    list(JOIN requires ", " requires)
    set(libs ${libs_PUBLIC} ${libs_PRIVATE})
    list(JOIN libs " " libs)
    set(requires_private "")
    set(libs_private "")
  endif()
  # From where the file is, so that the installed folder may be moved.
  cmake_path(IS_ABSOLUTE CMAKE_INSTALL_LIBDIR fixed)
  if(fixed)
    set(prefix ${CMAKE_INSTALL_PREFIX})
    set(libdir ${CMAKE_INSTALL_LIBDIR})
  else()
    file(RELATIVE_PATH prefix /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
    string(REGEX REPLACE "/$" "" prefix "\${pcfiledir}/${prefix}")
    set(libdir "\${prefix}/${CMAKE_INSTALL_LIBDIR}")
  endif()
  cmake_path(IS_ABSOLUTE CMAKE_INSTALL_INCLUDEDIR fixed)
  if(fixed)
    set(includedir ${CMAKE_INSTALL_INCLUDEDIR})
  else()
    set(includedir "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
  endif()
  foreach(line "prefix=${prefix}" "libdir=${libdir}" "includedir=${includedir}" "" "Name: ${module}"
          "Description: ${PROJECT_DESCRIPTION}: ${arg_DESCRIPTION}" "Version: ${PROJECT_VERSION}" "Requires: ${requires}"
          "Requires.private: ${requires_private}" "Cflags: -I\${includedir}"
          "Libs: -L\${libdir} -l${arg_LIBRARY} ${libs}" "Libs.private: ${libs_private}")
    if(NOT line MATCHES ": *$")
      string(STRIP "${line}" line)
      string(APPEND text "${line}\n")
    endif()
  endforeach()
  file(WRITE ${PROJECT_BINARY_DIR}/pkgconfig/${module}.pc "${text}")
  install(FILES ${PROJECT_BINARY_DIR}/pkgconfig/${module}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
    COMPONENT ${component})
endfunction()

# afferent_installs(<component> <target>...): they have to be built before that component is installed.
function(afferent_installs component)
  foreach(target IN LISTS ARGN)
    set_property(GLOBAL APPEND PROPERTY AFFERENT_INSTALLED "${component}|${target}|$<TARGET_FILE:${target}>")
  endforeach()
endfunction()

# Man pages and completions, which the program writes itself as soon as it is linked. Where it cannot be run, because
# it is built for another machine, they are left out.
function(afferent_install_manual component target)
  if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
    message(STATUS "No man pages and completions: ${target} cannot be run here")
    return()
  endif()
  set(share ${PROJECT_BINARY_DIR}/share/${target})
  add_custom_command(TARGET ${target} POST_BUILD
    COMMAND ${CMAKE_COMMAND} -D folder=${share} "-D program=$<TARGET_FILE:${target}>"
            "-D emulator=${CMAKE_CROSSCOMPILING_EMULATOR}" -P ${PROJECT_SOURCE_DIR}/cmake/write_manual.cmake
    VERBATIM)
  # The folder is there, empty, where an optional program was not built.
  file(MAKE_DIRECTORY ${share}/man)
  install(DIRECTORY ${share}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT ${component} ${ARGN})
  foreach(shell bash-completion zsh fish)
    install(DIRECTORY ${share}/${shell} DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT ${component} OPTIONAL)
  endforeach()
endfunction()

# Laid out as in the repository, so that the links between the pages hold.
function(afferent_install_documentation)
  install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documentation)
  install(DIRECTORY docs examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documentation PATTERN docs/site EXCLUDE)
  install(FILES proto/scene.proto proto/aer.proto proto/recording.proto DESTINATION ${CMAKE_INSTALL_DOCDIR}/proto
    COMPONENT documentation)
endfunction()

# What each component builds on, and the libraries that it links, directly or through others, and which headers are
# installed: tests/project compares documentation and headers with it.
function(afferent_write_component_table)
  set(table "")
  foreach(name IN LISTS AFFERENT_EXPORTED)
    set(all_${name} ${AFFERENT_${name}_LINKS})
    set(needs ${AFFERENT_${name}_NEEDS})
    foreach(need IN LISTS needs)
      list(APPEND all_${name} ${all_${need}})
    endforeach()
    list(REMOVE_DUPLICATES all_${name})
    list(REMOVE_DUPLICATES needs)
    list(SORT all_${name})
    list(SORT needs)
    string(APPEND table "${name}|${needs}|${all_${name}}\n")
  endforeach()
  file(WRITE ${PROJECT_BINARY_DIR}/components.txt "${table}")
  list(JOIN AFFERENT_PUBLIC_HEADERS "\n" headers)
  file(WRITE ${PROJECT_BINARY_DIR}/public_headers.txt "${headers}\n")
endfunction()

# The first thing that an installation does: all that it would copy is there, or it says how to build the rest.
function(afferent_check_what_is_built)
  install(SCRIPT ${PROJECT_BINARY_DIR}/check-built-$<CONFIG>.cmake ALL_COMPONENTS)
endfunction()

function(afferent_write_check_of_what_is_built)
  get_property(installed GLOBAL PROPERTY AFFERENT_INSTALLED)
  file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/check-built-$<CONFIG>.cmake CONTENT
"set(installed [==[${installed}]==])
set(build [==[${CMAKE_BINARY_DIR}]==])
include([==[${PROJECT_SOURCE_DIR}/cmake/check_built.cmake]==])
")
endfunction()

# `cpack` makes a Debian package, afferent, of all that is installed but the module for Python, which is python3-afferent
# where it is built. Configure with -DCMAKE_INSTALL_PREFIX=/usr for it, so that libraries lie where Debian has them, and with
# -DAFFERENT_PYTHON_DESTINATION=lib/python3/dist-packages.
function(afferent_make_packages)
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_CONTACT "The maintainers of Afferent")
  set(CPACK_PACKAGE_VENDOR Afferent)
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEB_COMPONENT_INSTALL ON)
  set(CPACK_DEBIAN_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME afferent)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "gnuplot-nox | gnuplot, fonts-liberation")
  # What programs take that embed the components in C++.
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "g++, cmake, libboost-dev, libcsv-dev, libhwy-dev, libisal-dev, libprotobuf-dev, \
libsodium-dev, libssl-dev, libtbb-dev, zlib1g-dev")
  if(AFFERENT_PYTHON)
    find_package(Python3 REQUIRED COMPONENTS Interpreter)
    set(CPACK_DEBIAN_MODULE_PACKAGE_NAME python3-afferent)
    set(CPACK_DEBIAN_MODULE_PACKAGE_SECTION python)
    set(CPACK_DEBIAN_MODULE_DESCRIPTION "The module for Python: import afferent.")
    # The compiled part is of one version of the interpreter.
    math(EXPR next "${Python3_VERSION_MINOR} + 1")
    set(CPACK_DEBIAN_MODULE_PACKAGE_DEPENDS
      "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next}), python3-numpy")
    set(CPACK_DEBIAN_MODULE_PACKAGE_SUGGESTS "python3-matplotlib, python3-neo, python3-pandas")
  endif()
  get_cmake_property(components COMPONENTS)
  set(CPACK_COMPONENTS_ALL ${components})
  include(CPack)
  cpack_add_component_group(program)
  cpack_add_component_group(module)
  foreach(component IN LISTS components)
    if(component STREQUAL "python")
      cpack_add_component(${component} GROUP module)
    else()
      cpack_add_component(${component} GROUP program)
    endif()
  endforeach()
endfunction()
