# What test/run and its modes share: steps, problems, the summary line. Sourced with bash, in the
# root of the source tree.

problems=()
passed=0 failed=0 skipped=0

# Other Pythons lack the modules of Debian's ROS. Another ROS, once it is sourced, has put its own
# first.
[ "${ROS_DISTRO:-Debian}" != Debian ] || export PATH=/usr/bin:/bin:$PATH
unset ROS_MASTER_URI ROS_HOSTNAME ROS_IP

say() { printf '\n== %s\n' "$*"; }

# Ends the run: with 0 if there is no problem, else with 1.
finish() {
  say "Result"
  for problem in "${problems[@]}"; do echo "FAILED: $problem"; done
  echo "$passed passed, $failed failed, $skipped skipped"
  [ ${#problems[@]} -eq 0 ]
  exit
}

# must PROBLEM COMMAND...: stops here if it fails; without this step nothing later makes sense.
must() {
  local problem=$1
  shift
  if ! "$@"; then
    problems+=("$problem")
    finish
  fi
}

# And says how CMake builds: a ROS elsewhere may go without ninja.
install_packages() {
  say "Packages"
  must "packages could not be installed" config/install_packages "$@"
  export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
  keep_going=(-k)
  if command -v ninja >/dev/null; then
    export CMAKE_GENERATOR=${CMAKE_GENERATOR:-Ninja}
    [ "$CMAKE_GENERATOR" != Ninja ] || keep_going=(-k 0)
  fi
}

# run_tests BUILD [ARGS of ctest...]: a skip is a problem where the test data are there.
run_tests() {
  local build=$1 log=$1/ctest.log total code inner
  shift
  say "Tests"
  export ROS_HOME=$build/ros_home
  rm -rf "$log" "$build/Testing" "$build/test_results"
  (cd "$build" && ctest --output-on-failure "$@") | tee "$log"
  code=${PIPESTATUS[0]}
  # Its last words: older CMakes write no report of use. Without a summary nothing ran.
  read -r failed total < <(sed -En \
    's/^[0-9]+% tests passed, ([0-9]+) tests? failed out of ([0-9]+)$/\1 \2/p' "$log" | tail -1)
  skipped=$(sed -n '/^The following tests did not run:$/,$p' "$log" | grep -c ' (Skipped)$')
  total=${total:-0} failed=${failed:-0}
  passed=$((total - failed - skipped))
  # rostests say in their own results that they were skipped.
  inner=$(grep -rlE '<skipped|\[  SKIPPED \]' "$build/test_results" 2>/dev/null)
  [ $code -eq 0 ] || problems+=("ctest: $failed of $total tests failed")
  [ "$total" -gt 0 ] || problems+=("no test ran")
  if [ -d "${DCM_TEST_DATA:-$PWD/../shared/data}" ]; then
    [ "$skipped" -eq 0 ] ||
      problems+=("$skipped tests were skipped, although the test data are there")
    [ -z "$inner" ] || problems+=("skipped within: $inner")
  else
    echo "The test data are not there: tests that need them were SKIPPED."
  fi
}
