# Runs clang-tidy, for test/run --tidy. bash sources this file after test/checks.sh.

# changed_files COMMIT: prints the files of src and cuda that differ from it, new ones as well.
changed_files() {
  { git diff --name-only --diff-filter=d "$1" && git ls-files --others --exclude-standard; } |
    grep -E '^(src|cuda)/.*\.(h|cpp|cu|cuh)$' | sort -u
}

# Prints the commit at which this branch left main; on main, the last commit but one.
default_commit() {
  local base
  base=$(git merge-base HEAD main 2>/dev/null || git merge-base HEAD origin/main 2>/dev/null)
  if [ -z "$base" ] || [ "$base" = "$(git rev-parse HEAD)" ]; then base=HEAD~1; fi
  git rev-parse --verify --quiet "$base"
}

# tidy_file FILE: runs clang-tidy on it. Prints "ok FILE", or what was found and "FAILED FILE".
tidy_file() {
  local file=$1 arguments log
  case $file in
    *.cu | *.cuh)
      arguments=(-- -x cuda --cuda-host-only -nocudainc -nocudalib -Xclang
        -fcuda-allow-variadic-functions -Wno-unknown-cuda-version -Wno-pragma-once-outside-header
        -std=c++17 -isystem "$CUDA_HEADERS" -isystem "$CUDA_HEADERS/cccl" -I"$PWD" -I"$PWD/src"
        -include "$PWD/test/support/clang_cuda.h") ;;
    *) arguments=(-p build/tidy) ;;
  esac
  if log=$(clang-tidy --quiet "$PWD/$file" "${arguments[@]}" 2>&1); then
    echo "ok $file"
  else
    printf '%s\nFAILED %s\n' "$log" "$file"
  fi
}

# tidy --tidy[=all|=COMMIT] [FILE...]: checks these files, and counts them as passed or failed.
tidy() {
  local commit=${1#--tidy} files log headers
  commit=${commit#=}
  shift
  if [ $# -gt 0 ]; then
    mapfile -t files < <(realpath --relative-to="$PWD" -- "$@")
  elif [ "$commit" = all ]; then
    # Headers are read with the sources that include them.
    mapfile -t files < <(find src cuda -name '*.cpp' -o -name '*.cu' | sort)
  else
    [ -n "$commit" ] || commit=$(default_commit)
    git rev-parse --verify --quiet "$commit^{commit}" >/dev/null ||
      must "there is no commit '$commit' to compare with" false
    mapfile -t files < <(changed_files "$commit")
  fi
  install_packages build run tidy

  say "The flags of each file, and the messages"
  must "configuring" cmake -S . -B build/tidy -G Ninja -DWITH_CUDA=OFF -DBUILD_BENCHMARKS=OFF
  must "generating messages" cmake --build build/tidy \
    --target deformable_contact_monitor_generate_messages_cpp deformable_contact_monitor_gencfg

  say "clang-tidy on ${#files[@]} files"
  [ ${#files[@]} -gt 0 ] || return 0
  CUDA_HEADERS=$(dirname "$(ls {/usr/local/cuda,/usr}/include/cuda_runtime.h 2>/dev/null | head -1)")
  if [ "$CUDA_HEADERS" = . ]; then
    skipped=$(printf '%s\n' "${files[@]}" | grep -cE '\.cuh?$')
    mapfile -t files < <(printf '%s\n' "${files[@]}" | grep -vE '\.cuh?$')
    echo "There are no CUDA headers: $skipped files were SKIPPED."
  fi
  export CUDA_HEADERS
  export -f tidy_file
  log=build/tidy/clang-tidy.log
  printf '%s\n' "${files[@]}" |
    xargs -r -d '\n' -P "$(nproc)" -I{} bash -c 'tidy_file {}' | tee "$log"
  passed=$(grep -c '^ok ' "$log")
  failed=$((${#files[@]} - passed))
  [ "$failed" -eq 0 ] || problems+=("clang-tidy: $failed of ${#files[@]} files")
}
