#!/usr/bin/python3
"""rewrite.py WORKTREE GEN: the tree with its CUDA text as C++ for the emulator; writes what differs alone."""
import os, re, shutil, subprocess, sys

src, gen = sys.argv[1:3]
EMU = os.path.dirname(os.path.abspath(__file__))

def matching(text, at):  # the end of a bracket that opens at `at`
    depth = 0
    for i in range(at, len(text)):
        if text[i] in '([{':
            depth += 1
        elif text[i] in ')]}':
            depth -= 1
            if depth == 0:
                return i
    raise ValueError

def launches(text):
    out, pos = '', 0
    for m in re.finditer(r'([A-Za-z_][\w:]*(?:<[^<>;{}]*>)?)\s*<<<', text):
        if m.start() < pos:
            continue
        end = text.index('>>>', m.end())
        opening = text.index('(', end)
        close = matching(text, opening)
        args = text[opening + 1:close].strip()
        kernel = m.group(1)
        out += text[pos:m.start()] + 'emu::Config(%s).run("%s", %s%s)' % (
            text[m.end():end], kernel, kernel, ', ' + args if args else '')
        pos = close + 1
    return out + text[pos:]

def cuda(name, text):
    text = launches(text)
    text = re.sub(r'(?<![\w.>])threadIdx\b', '(emu::state.now->tid)', text)
    text = re.sub(r'(?<![\w.>])(blockDim|gridDim)\b', r'(emu::state.\1)', text)
    text = re.sub(r'(?<![\w.>])blockIdx\b', '(emu::state.block)', text)
    text = re.sub(r'extern\s+__shared__\s+(?:__align__\(\d+\)|alignas\(\d+\))?\s*([\w:]+(?:\s\w+)?)\s+(\w+)\[\]\s*;',
                  r'\1* const \2 = static_cast<\1*>(emu::dynamicShared());', text)
    text = re.sub(r'#pragma (unroll|nv_diag\w*).*', '', text)
    text = re.sub(r'\basm\s+(volatile\s*)?\(', 'EMU_NO_ASM(', text)
    if name.endswith('device_memory.cuh'):
        text = text.replace('return static_cast<T*>(data_)[i.value];',
                            'emu::checkIndex(i.value, rows_, __PRETTY_FUNCTION__); return static_cast<T*>(data_)[i.value];')
        text = text.replace('{ return static_cast<T*>(data_) + std::size_t{i.value} * kRow; }',
                            '{ emu::checkIndex(i.value, rows_ + 1, __PRETTY_FUNCTION__); return static_cast<T*>(data_) + std::size_t{i.value} * kRow; }')
    return text

def cmake(name, text):
    text = re.sub(r'\.cu\b', '.cu.cpp', text)
    text = text.replace('--Werror=all-warnings', '-w').replace('--fmad=false', '-w')
    text = re.sub(r'LINKER_LANGUAGE CUDA', 'LINKER_LANGUAGE CXX', text)
    text = re.sub(r'CUDA_RUNTIME_LIBRARY Static', '', text)
    text = re.sub(r'set_target_properties\(\w+ PROPERTIES\s*\)', '', text)
    if name == 'cuda/nvcc.cmake':
        text = 'set(DCM_CUDA_ENABLED ON)\n'
    if name == 'cuda/CMakeLists.txt':
        text = text.replace('target_link_libraries(dcm_cuda PUBLIC dcm_core)',
                            'target_link_libraries(dcm_cuda PUBLIC dcm_core emu_cudart)\n'
                            'target_compile_options(dcm_cuda PRIVATE -w -O1)')
    if name == 'CMakeLists.txt':
        text = text.replace('add_subdirectory(src/core)', '''add_library(emu_cudart STATIC %s/emu.cpp)
target_include_directories(emu_cudart BEFORE PUBLIC %s/include)
target_include_directories(emu_cudart SYSTEM PUBLIC /usr/local/cuda/include)
target_compile_options(emu_cudart PRIVATE -O2 -w)
target_compile_options(emu_cudart INTERFACE -ffp-contract=off -ftls-model=initial-exec)
add_subdirectory(src/core)''' % (EMU, EMU))
    return text

files = subprocess.run(['git', 'ls-files', '-co', '--exclude-standard'], cwd=src, check=True,
                       stdout=subprocess.PIPE, text=True).stdout.split('\n')
kept = set()
for name in files:
    path = os.path.join(src, name)
    if not name or not os.path.isfile(path):
        continue
    data = open(path, 'rb').read()
    to = name
    if name.endswith(('.cu', '.cuh')):
        data = cuda(name, data.decode()).encode()
        if name.endswith('.cu'):
            to = name + '.cpp'
            data = b'#include <cuda_runtime.h>\n#line 1\n' + data
    elif name.endswith(('CMakeLists.txt', '.cmake')):
        data = cmake(name, data.decode()).encode()
    out = os.path.join(gen, to)
    kept.add(to)
    if os.path.exists(out) and open(out, 'rb').read() == data:
        continue
    os.makedirs(os.path.dirname(out), exist_ok=True)
    with open(out, 'wb') as f:
        f.write(data)
for folder, _, names in os.walk(gen):
    for n in names:
        rel = os.path.relpath(os.path.join(folder, n), gen)
        if rel not in kept and not rel.startswith('build/'):
            os.remove(os.path.join(gen, rel))
