# SPDX-License-Identifier: MIT
# turnscale_manual(<component> <command>...): compressed pages of section 1 made from the help texts of these sub-commands,
# and of the program itself where `turnscale` is among them. Installed with the component.
function(turnscale_manual component)
  set(pages "")
  foreach(command IN LISTS ARGN)
    if(command STREQUAL "turnscale")
      set(name turnscale)
    else()
      set(name turnscale-${command})
    endif()
    set(help "")
    if(command STREQUAL "batch")
      set(help ${PROJECT_SOURCE_DIR}/fleet/turnscale_batch/cli.py)
    endif()
    set(page ${CMAKE_CURRENT_BINARY_DIR}/man/${name}.1.gz)
    add_custom_command(
      OUTPUT ${page}
      COMMAND
        ${CMAKE_COMMAND} -DHELP2MAN=${HELP2MAN} -DGZIP=${GZIP} -DPROGRAM=$<TARGET_FILE:turnscale> -DNAME=${name}
        -DVERSION=${PROJECT_VERSION} -DCHANGELOG=${PROJECT_SOURCE_DIR}/CHANGELOG.md -DOUTPUT=${page} -P
        ${PROJECT_SOURCE_DIR}/cmake/WriteManualPage.cmake
      DEPENDS turnscale $<TARGET_NAME_IF_EXISTS:turnscale_simulator> ${PROJECT_SOURCE_DIR}/cmake/WriteManualPage.cmake
              ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${help}
      COMMENT "Manual page ${name}(1)"
      VERBATIM)
    list(APPEND pages ${page})
  endforeach()
  add_custom_target(turnscale_manual_${component} ALL DEPENDS ${pages})
  install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component})
endfunction()
