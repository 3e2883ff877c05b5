# Hardening, by the system's compiler and linker (SECURITY.md).

# Libraries are looked for where the system has them and nowhere else: an empty entry of a RUNPATH, as CMake pads
# them, is the folder that a program is started in.
set(CMAKE_SKIP_RPATH ON)
add_link_options(-Wl,-z,relro,-z,now)
