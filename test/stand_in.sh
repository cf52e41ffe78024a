# A root of Debian 11 with g++ 9, the nearest that Debian's archive has to Ubuntu 20.04, and what is
# built and tested there. For test/run --stand-in and --aarch64. Sourced after test/checks.sh.

stand_in_package=/tree/package  # within the root

# section FILE NAME: the packages that FILE lists under "# NAME".
section() { sed -n "/^# $2\$/,/^# /{/^[^#]/p}" "$1"; }

# The packages of a root: `core` is what the core takes, here and for aarch64, `whole` what all does.
stand_in_packages() {
  local name
  section test/stand_in_packages.txt "$1"
  [ "$1" = core ] || for name in build run test; do section config/debian_packages.txt $name; done
}

# make_stand_in core|whole: sets $stand_in to such a root, which lies outside of the tree and is made
# again when the list of packages changes. Fails where it cannot be had.
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
  # Its rospy and roslaunch are of before Python 3.9, which it has.
  echo "import threading; threading.Thread.isAlive = threading.Thread.is_alive" \
    >>"$stand_in/etc/python3.9/sitecustomize.py"
  echo "$packages" >"$mark"
}

# in_stand_in COMMAND...: runs it there, in the package's folder, with the folder of the test data
# beside it. What is mounted for it is gone afterwards.
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

# This tree as it stands, without what git ignores. Build folders there stay, for the next time.
copy_to_stand_in() {
  local to=$stand_in$stand_in_package
  mkdir -p "$to"
  find "$to" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
  git ls-files -z --cached --others --exclude-standard |
    tar -c --null --ignore-failed-read -T - 2>/dev/null | tar -x -C "$to"
}

# stand_in_tests ROOT WHAT: as test/stand_in_tests WHAT, in the root ROOT (core, whole); its counts are
# added to this run's. Said aloud where there can be no such root.
stand_in_tests() {
  local log=build/stand_in_$2.log counts
  say "On Debian 11: $2"
  mkdir -p build
  if ! make_stand_in "$1"; then
    echo "SKIPPED: there is no Debian 11 to be had here, see above"
    return 1
  fi
  copy_to_stand_in
  in_stand_in test/stand_in_tests "$2" 2>&1 | tee "$log"
  [ "${PIPESTATUS[0]}" -eq 0 ] || problems+=("on Debian 11: $2, see $log")
  counts=$(tail -1 "$log")
  [[ $counts =~ ^([0-9]+)\ passed,\ ([0-9]+)\ failed,\ ([0-9]+)\ skipped$ ]] || return 1
  passed=$((passed + BASH_REMATCH[1])) failed=$((failed + BASH_REMATCH[2]))
  skipped=$((skipped + BASH_REMATCH[3]))
}

# aarch64_tests all|few DETECT_CONTACTS: the core built for that processor and tested under qemu;
# its pairs are those of DETECT_CONTACTS, this machine's, byte for byte.
aarch64_tests() {
  local what=aarch64 data=${DCM_TEST_DATA:-$PWD/../shared/data} theirs
  [ "$1" = all ] || what=aarch64_few
  stand_in_tests core $what || return
  [ -d "$data" ] || return
  theirs=$stand_in$stand_in_package/build/pairs
  test/pair_files "$1" "$data" build/pairs "$2" && diff -rq build/pairs "$theirs" ||
    problems+=("aarch64: other pairs than here")
  echo "$(ls "$theirs" | wc -l) files of pairs compared: $(cat "$theirs"/* | wc -l) lines"
}
