# One folder is one target (afferent::<name>) and one component of the installed package.

include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(AFFERENT_EXPORTED "" CACHE INTERNAL "")
set(AFFERENT_PUBLIC_HEADERS "" CACHE INTERNAL "")
include(${CMAKE_CURRENT_LIST_DIR}/packaging.cmake)

# Headers are included as <afferent/runtime/event.hpp>, before and after installing: a link stands for the
# installed folder.
set(AFFERENT_INCLUDE_DIR ${PROJECT_BINARY_DIR}/include)
set(AFFERENT_GENERATED_DIR ${PROJECT_BINARY_DIR}/generated)
file(MAKE_DIRECTORY ${AFFERENT_INCLUDE_DIR}/afferent ${AFFERENT_GENERATED_DIR})

add_library(afferent_options INTERFACE)
# The same events for any compiler and optimisation level: no contraction of a*b+c behind our back.
target_compile_options(afferent_options INTERFACE
  -ffp-contract=off -Wall -Wextra -Wpedantic -Wconversion -Wshadow
  $<$<BOOL:${AFFERENT_WERROR}>:-Werror>)
# Not a generator expression: the list of sanitizers has commas in it.
if(AFFERENT_SANITIZE)
  # Left out is what takes longest to compile and to run, and tells least: AddressSanitizer sees what a null pointer, a wrong
  # object or a pointer beyond its array would read, and bytes are copied into other types, not read in place.
  target_compile_options(afferent_options INTERFACE
    -fsanitize=${AFFERENT_SANITIZE} -fno-sanitize=null,vptr,alignment,pointer-overflow -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(afferent_options INTERFACE -fsanitize=${AFFERENT_SANITIZE})
  # A program at a fixed address relocates nothing and starts in two thirds of the time, which counts in thousands of tests.
  if(AFFERENT_SANITIZE MATCHES "address")
    target_link_options(afferent_options INTERFACE $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-no-pie>)
  endif()
endif()
# Once they are sanitized, g++ takes parts of std::regex for uninitialized.
if(AFFERENT_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(afferent_options INTERFACE -Wno-maybe-uninitialized)
endif()
# Asio's fences are not understood by it; what it reports of them would be wrong, and nothing here relies on them.
if(AFFERENT_SANITIZE STREQUAL "thread" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(afferent_options INTERFACE -Wno-tsan)
endif()

# Reads in the folders' CMakeLists.txt what their components build on, and sets in the caller: `folders`, without those none of
# whose components is chosen by AFFERENT_ONLY, and AFFERENT_CHOSEN, by which a folder leaves out what it has besides. So
# nothing is looked for that is not needed.
function(afferent_choose_components)
  set(all "")
  foreach(folder IN LISTS ARGN)
    file(READ ${PROJECT_SOURCE_DIR}/${folder}/CMakeLists.txt text)
    string(REGEX MATCHALL "afferent_component\\([^)]*" calls "${text}")
    foreach(call IN LISTS calls)
      string(REGEX REPLACE "^afferent_component\\(([a-z0-9_]+).*" "\\1" name "${call}")
      string(REGEX MATCHALL "afferent::[a-z0-9_]+" needs_${name} "${call}")
      list(TRANSFORM needs_${name} REPLACE "afferent::" "")
      list(APPEND all ${name})
      list(APPEND of_${folder} ${name})
    endforeach()
  endforeach()
  set(chosen ${AFFERENT_ONLY})
  if(NOT chosen)
    set(chosen ${all})
  endif()
  set(next ${chosen})
  while(next)
    list(POP_FRONT next name)
    if(NOT name IN_LIST all)
      list(JOIN all ", " all)
      message(FATAL_ERROR "AFFERENT_ONLY: there is no component ${name}. There are: ${all}")
    endif()
    foreach(need IN LISTS needs_${name})
      if(NOT need IN_LIST chosen)
        list(APPEND chosen ${need})
        list(APPEND next ${need})
      endif()
    endforeach()
  endwhile()
  set(folders "")
  foreach(folder IN LISTS ARGN)
    foreach(name IN LISTS of_${folder})
      if(name IN_LIST chosen)
        list(APPEND folders ${folder})
        break()
      endif()
    endforeach()
  endforeach()
  set(folders ${folders} PARENT_SCOPE)
  set(AFFERENT_CHOSEN ${chosen} PARENT_SCOPE)
endfunction()

# For sources that Highway compiles once for each instruction set, whose structs hold vectors. On arm64 those of SVE, whose length
# only the machine knows, cannot be held; and g++ compiles the constructors that it defines itself for the instruction set of
# the file alone, so that it has to be that of NEON in Highway. Nothing of "crypto" is used.
function(afferent_compile_for_each_instruction_set)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "-march=armv8-a+crypto"
      COMPILE_DEFINITIONS "HWY_DISABLED_TARGETS=(HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128)")
  endif()
endfunction()

# afferent_component(<name>
#   SOURCES <file>...        compiled into the component
#   HEADERS_FROM <folder>    the folder its headers are in; default: this one (NONE: it has none of its own)
#   PUBLIC_HEADERS <file>...  those of them that are installed, and all that they include; default: none
#   INTERNAL                 no program embeds it: it is neither exported nor, where it is static, installed
#   BATCH <number>           so many sources are compiled at once, where a compiler would take more than 700 MB for 16
#   BESIDE_EVENTS            nothing of it runs for each event: optimising it takes long and gains nothing
#   DEPENDS <target>...      public dependencies
#   PRIVATE_DEPENDS <target>...
#   PACKAGES <name>...       what a consumer has to find first, as for find_dependency
# )
function(afferent_component name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "INTERNAL;BESIDE_EVENTS" "HEADERS_FROM;BATCH" "SOURCES;PUBLIC_HEADERS;DEPENDS;PRIVATE_DEPENDS;PACKAGES")
  set(target afferent_${name})
  # Static, unless BUILD_SHARED_LIBS asks for shared ones. Before 1.0 their binary interface holds for a minor version.
  add_library(${target} ${arg_SOURCES})
  add_library(afferent::${name} ALIAS ${target})
  if(arg_BESIDE_EVENTS)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} UNITY_BUILD ${AFFERENT_UNITY}
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  if(arg_BATCH)
    set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE ${arg_BATCH})
  endif()
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${AFFERENT_INCLUDE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target}
    PUBLIC ${arg_DEPENDS} PRIVATE ${arg_PRIVATE_DEPENDS} $<BUILD_INTERFACE:afferent_options>)
  if(NOT arg_HEADERS_FROM STREQUAL "NONE")
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
    get_filename_component(parent ${AFFERENT_INCLUDE_DIR}/afferent/${folder} DIRECTORY)
    file(MAKE_DIRECTORY ${parent})
    # That of a folder within a component's is there already.
    if(NOT EXISTS ${AFFERENT_INCLUDE_DIR}/afferent/${folder})
      file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${AFFERENT_INCLUDE_DIR}/afferent/${folder} SYMBOLIC)
    endif()
    list(TRANSFORM arg_PUBLIC_HEADERS PREPEND ${folder}/ OUTPUT_VARIABLE public)
    set(AFFERENT_PUBLIC_HEADERS ${AFFERENT_PUBLIC_HEADERS} ${public} CACHE INTERNAL "")
    install(FILES ${arg_PUBLIC_HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/afferent/${folder} COMPONENT ${name})
  endif()
  if(arg_INTERNAL)
    if(BUILD_SHARED_LIBS)
      install(TARGETS ${target} COMPONENT program DESTINATION ${CMAKE_INSTALL_LIBDIR})
      afferent_installs(program ${target})
    endif()
    return()
  endif()

  set(needs "")
  foreach(dependency IN LISTS arg_DEPENDS arg_PRIVATE_DEPENDS)
    if(dependency MATCHES "^afferent::(.+)$")
      list(APPEND needs ${CMAKE_MATCH_1})
    endif()
  endforeach()
  afferent_export(${name} NEEDS ${needs} PACKAGES ${arg_PACKAGES})
  afferent_pkg_config(${name} LIBRARY afferent_${name} DESCRIPTION "component ${name}"
    PUBLIC ${arg_DEPENDS} PRIVATE ${arg_PRIVATE_DEPENDS})
endfunction()

# Makes afferent_<name> a component of the package. It needs those components and packages of its consumers.
function(afferent_export name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "NEEDS;PACKAGES")
  install(TARGETS afferent_${name} EXPORT afferent-${name} COMPONENT ${name} DESTINATION ${CMAKE_INSTALL_LIBDIR})
  afferent_installs(${name} afferent_${name})
  install(EXPORT afferent-${name} NAMESPACE afferent:: COMPONENT ${name}
    FILE afferent-${name}.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/afferent)
  set(AFFERENT_EXPORTED ${AFFERENT_EXPORTED} ${name} CACHE INTERNAL "")
  set(AFFERENT_${name}_NEEDS "${arg_NEEDS}" CACHE INTERNAL "")
  set(AFFERENT_${name}_PACKAGES "${arg_PACKAGES}" CACHE INTERNAL "")
endfunction()

function(afferent_install_package)
  set(AFFERENT_COMPONENT_TABLE "")
  foreach(name IN LISTS AFFERENT_EXPORTED)
    string(APPEND AFFERENT_COMPONENT_TABLE
      "set(_afferent_${name}_needs ${AFFERENT_${name}_NEEDS})\n"
      "set(_afferent_${name}_packages ${AFFERENT_${name}_PACKAGES})\n")
  endforeach()
  set(folder ${CMAKE_INSTALL_LIBDIR}/cmake/afferent)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/afferent-config.cmake.in
    ${PROJECT_BINARY_DIR}/afferent-config.cmake INSTALL_DESTINATION ${folder})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/afferent-config-version.cmake
    COMPATIBILITY SameMinorVersion)
  # With each of them, so that any can be installed by itself.
  foreach(name IN LISTS AFFERENT_EXPORTED)
    install(FILES ${PROJECT_BINARY_DIR}/afferent-config.cmake ${PROJECT_BINARY_DIR}/afferent-config-version.cmake
      DESTINATION ${folder} COMPONENT ${name})
  endforeach()
  afferent_write_component_table()
  afferent_write_check_of_what_is_built()
endfunction()
