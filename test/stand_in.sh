# Makes a root of Debian 11 with g++ 9, the nearest that Debian has to Ubuntu 20.04, and builds and
# tests there. For test/run --stand-in and --aarch64; bash sources this file after test/checks.sh.

stand_in_package=/tree/package  # within the root

# section FILE NAME: prints the packages that FILE lists under "# NAME".
section() { sed -n "/^# $2\$/,/^# /{/^[^#]/p}" "$1"; }

# stand_in_packages core|whole: prints the packages that the root needs to build the core, for this
# processor and aarch64, or the whole package.
stand_in_packages() {
  local name
  section test/stand_in_packages.txt "$1"
  [ "$1" = core ] || for name in build run test; do section config/debian_packages.txt $name; done
}

# make_stand_in core|whole: sets $stand_in to such a root, which lies outside of the tree. Makes it if
# it is not there or the list of packages has changed. Fails where it cannot be made.
make_stand_in() {
  local packages mark log
  packages=$(stand_in_packages "$1")
  stand_in=${XDG_CACHE_HOME:-$HOME/.cache}/deformable_contact_monitor/debian11-$1
  mark=$stand_in/packages.txt log=$stand_in.log
  [ "$(cat "$mark" 2>/dev/null)" = "$packages" ] && return
  [ "$(id -u)" -eq 0 ] || { echo "needs root, for debootstrap and chroot"; return 1; }
  config/install_packages stand_in || return 1
  rm -rf --one-file-system "$stand_in"
  mkdir -p "$stand_in"
  echo "makes a root of Debian 11 in $stand_in (minutes)"
  # shellcheck disable=SC2086
  debootstrap --variant=minbase bullseye "$stand_in" >"$log" 2>&1 &&
    cp -L /etc/resolv.conf "$stand_in/etc/" &&
    echo "127.0.0.1 localhost $(hostname)" >"$stand_in/etc/hosts" &&
    chroot "$stand_in" dpkg --add-architecture arm64 &&
    chroot "$stand_in" apt-get update -qq >>"$log" 2>&1 &&
    chroot "$stand_in" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -qq --no-install-recommends $packages >>"$log" 2>&1 ||
    { tail -5 "$log"; return 1; }
  # Its rospy and roslaunch are older than its Python 3.9, which dropped this name.
  echo "import threading; threading.Thread.isAlive = threading.Thread.is_alive" \
    >>"$stand_in/etc/python3.9/sitecustomize.py"
  echo "$packages" >"$mark"
}

# in_stand_in COMMAND...: runs it there, in the package's folder, with the folder of the test data
# beside it. The mounts that this takes end with the command.
in_stand_in() {
  local beside=$stand_in/tree/shared data=${DCM_TEST_DATA:-$PWD/../shared/data}
  mkdir -p "$stand_in/tree"
  if [ -d "$data" ]; then mkdir -p "$beside"; else rm -rf --one-file-system "$beside"; fi
  # shellcheck disable=SC2016
  unshare --mount -- bash -c '
    root=$1 package=$2 data=$3
    shift 3
    mount --rbind /proc "$root/proc" && mount --rbind /dev "$root/dev" || exit 1
    [ ! -d "$data" ] || mount --bind "$data/.." "$root/tree/shared" || exit 1
    exec chroot "$root" env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \
      bash -c "cd $package && exec \"\$@\"" bash "$@"' \
    bash "$stand_in" "$stand_in_package" "$data" "$@"
}

# Copies this tree as it stands, without what git ignores. Build folders there are kept.
copy_to_stand_in() {
  local to=$stand_in$stand_in_package
  mkdir -p "$to"
  find "$to" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
  git ls-files -z --cached --others --exclude-standard |
    tar -c --null --ignore-failed-read -T - 2>/dev/null | tar -x -C "$to"
}

# stand_in_tests ROOT WHAT: runs test/stand_in_tests WHAT in the root ROOT (core or whole), and adds
# its counts to this run's. Prints SKIPPED where there can be no such root.
stand_in_tests() {
  local log=build/stand_in_$2.log
  say "On Debian 11: $2"
  mkdir -p build
  if ! make_stand_in "$1"; then
    echo "SKIPPED: a root of Debian 11 cannot be made here, see above"
    return 1
  fi
  copy_to_stand_in
  in_stand_in test/stand_in_tests "$2" 2>&1 | tee "$log"
  [ "${PIPESTATUS[0]}" -eq 0 ] || problems+=("on Debian 11: $2, see $log")
  add_counts "$log"
}

# aarch64_tests DETECT_CONTACTS: builds the core for aarch64 and runs its tests under qemu. Then
# compares its pairs of 22 scenes with those of DETECT_CONTACTS, a program of this machine.
aarch64_tests() {
  local data=${DCM_TEST_DATA:-$PWD/../shared/data} theirs
  stand_in_tests core aarch64 || return
  [ -d "$data" ] || return
  theirs=$stand_in$stand_in_package/build/pairs
  test/pair_files "$data" build/pairs "$1" && diff -rq build/pairs "$theirs" ||
    problems+=("aarch64: other pairs than here")
  echo "$(ls "$theirs" | wc -l) files of pairs compared: $(cat "$theirs"/* | wc -l) lines"
}
