# Makes roots of other Debian releases, and builds and tests there: Debian 11 with g++ 9, the nearest
# that Debian has to Ubuntu 20.04, for test/run --stand-in and --aarch64; and Debian 13 for --debian13.
# bash sources this file after test/checks.sh.

PATH=$PATH:/usr/sbin  # debootstrap and chroot are there, where not every PATH leads
stand_in_package=/tree/package  # within the root

# section FILE NAME: prints the packages that FILE lists under "# NAME".
section() { sed -n "/^# $2\$/,/^# /{/^[^#]/p}" "$1"; }

# stand_in_packages ROOT: prints the packages that the root needs.
stand_in_packages() {
  local name
  section test/stand_in_packages.txt "$1"
  [ "$1" != whole ] || for name in build run test; do section config/debian_packages.txt $name; done
}

# make_stand_in core|whole|debian13: sets $stand_in to such a root, which lies outside of the tree.
# Makes it if it is not there or the list of packages has changed. Fails where it cannot be made.
make_stand_in() {
  local packages mark log release=bullseye
  packages=$(stand_in_packages "$1")
  stand_in=${XDG_CACHE_HOME:-$HOME/.cache}/deformable_contact_monitor/debian11-$1
  [ "$1" != debian13 ] || { release=trixie stand_in=${stand_in/debian11-/}; }
  mark=$stand_in/packages.txt log=$stand_in.log
  [ "$(cat "$mark" 2>/dev/null)" = "$packages" ] && return
  [ "$(id -u)" -eq 0 ] || { echo "needs root, for debootstrap and chroot"; return 1; }
  config/install_packages stand_in || return 1
  rm -rf --one-file-system "$stand_in"
  mkdir -p "$stand_in"
  echo "makes a root of $release in $stand_in (minutes)"
  # shellcheck disable=SC2086
  debootstrap --variant=minbase $release "$stand_in" >"$log" 2>&1 &&
    cp -L /etc/resolv.conf "$stand_in/etc/" &&
    echo "127.0.0.1 localhost $(hostname)" >"$stand_in/etc/hosts" &&
    chroot "$stand_in" dpkg --add-architecture arm64 &&
    chroot "$stand_in" apt-get update -qq >>"$log" 2>&1 &&
    chroot "$stand_in" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -qq --no-install-recommends $packages >>"$log" 2>&1 ||
    { tail -5 "$log"; return 1; }
  # Debian 11's rospy and roslaunch are older than its Python 3.9, which dropped this name.
  [ $release != bullseye ] ||
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

# stand_in_tests ROOT WHAT: runs test/stand_in_tests WHAT in the root ROOT (see make_stand_in), and
# adds its counts to this run's. Prints SKIPPED where there can be no such root.
stand_in_tests() {
  local log=build/stand_in_$2.log
  say "In another Debian: $2"
  mkdir -p build
  if ! make_stand_in "$1"; then
    echo "SKIPPED: the root cannot be made here, see above"
    return 1
  fi
  copy_to_stand_in
  in_stand_in test/stand_in_tests "$2" 2>&1 | tee "$log"
  [ "${PIPESTATUS[0]}" -eq 0 ] || problems+=("in another Debian: $2, see $log")
  add_counts "$log"
}

# compare_pairs WHO THEIRS DETECT_CONTACTS: compares the files of pairs in the folder THEIRS, which a
# build of WHO wrote, with those of DETECT_CONTACTS, a program of this machine, byte by byte.
compare_pairs() {
  local data=${DCM_TEST_DATA:-$PWD/../shared/data}
  [ -d "$data" ] || return 0
  test/pair_files "$data" build/pairs "$3" && diff -rq build/pairs "$2" ||
    problems+=("$1: other pairs than here")
  echo "$(ls "$2" | wc -l) files of pairs compared with $1: $(cat "$2"/* | wc -l) lines"
}

# Runs WHAT in ROOT (see stand_in_tests), and compares its pairs of 20 scenes with those of
# DETECT_CONTACTS, a program of this machine.
stand_in_tests_and_pairs() {
  stand_in_tests "$1" "$2" || return
  compare_pairs "$2" "$stand_in$stand_in_package/build/pairs" "$3"
}
