# SPDX-License-Identifier: MIT
# For find modules: makes the target <package>::<component> of an include folder and a library file, and sets
# <package>_<component>_FOUND. Does nothing where either was not found.

macro(imported_component package component include_folder library)
  if(${include_folder} AND ${library})
    set(${package}_${component}_FOUND TRUE)
    if(NOT TARGET ${package}::${component})
      add_library(${package}::${component} UNKNOWN IMPORTED)
      set_target_properties(${package}::${component} PROPERTIES IMPORTED_LOCATION "${${library}}"
                                                                INTERFACE_INCLUDE_DIRECTORIES "${${include_folder}}")
    endif()
  endif()
endmacro()
