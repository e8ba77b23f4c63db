#!/usr/bin/env bash
# Writes the completion of bash and zsh for shearwater and shearwater-worker, from the options that the programs
# themselves know (--dump-options, proto/option_text.h).
#   deploy/completion.sh BUILD_DIR OUT_DIR
# Makes OUT_DIR/shearwater (bash) and OUT_DIR/_shearwater (zsh).
set -euo pipefail
build=${1:?usage: deploy/completion.sh BUILD_DIR OUT_DIR}
out=${2:?usage: deploy/completion.sh BUILD_DIR OUT_DIR}
mkdir -p "$out"
# The worker counts as a command of its own name.
records() {
    "$build/shearwater" --dump-options
    printf 'command\tshearwater-worker\ttrace tiles\n'
    "$build/shearwater-worker" --dump-options
}
# What follows an option: one of some words, a file, or anything.
shared='
    function is_words(value) { return value ~ /\|/ }
    function is_file(value) { return value ~ /FILE|DIR|PLAN|\./ }
    function words(value) { gsub(/\|/, " ", value); return value }'

records | awk -F '\t' "$shared"'
    $1 == "command" { command = $2; order[++count] = command; if (command !~ /^shearwater/) commands = commands " " command }
    $1 == "usage" && $2 ~ / [A-Z]+[.][a-z]+| FILE / { files = files (files ? "|" : "") command }
    $1 == "option" {
        options[command] = options[command] " " $3
        name = command " " $3; if ($2) name = name "\x27|\x27" command " " $2
        if (is_words($4)) special = special "    \x27" name "\x27) _shearwater_words \x27" words($4) "\x27; return ;;\n"
        else if (is_file($4)) special = special "    \x27" name "\x27) _shearwater_files; return ;;\n"
        else if ($4) special = special "    \x27" name "\x27) return ;;\n"
    }
    END {
        print "# Completion of bash for shearwater and shearwater-worker."
        print "_shearwater_words() { mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"$current\"); }"
        print "_shearwater_files() {"
        print "    compopt -o filenames 2>/dev/null"
        print "    mapfile -t COMPREPLY < <(compgen -f -- \"$current\")"
        print "}"
        print "_shearwater() {"
        print "    local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[0]##*/}"
        print "    COMPREPLY=()"
        print "    if [ \"$command\" = shearwater ]; then"
        print "        [ \"$COMP_CWORD\" -gt 1 ] || { _shearwater_words \x27" substr(commands, 2) " --help --version\x27; return; }"
        print "        command=${COMP_WORDS[1]}"
        print "    fi"
        print "    case \"$command $before\" in"
        printf "%s", special
        print "    esac"
        print "    case $command:$current in"
        for (i = 1; i <= count; i++) print "    " order[i] ":-*) _shearwater_words \x27" substr(options[order[i]], 2) "\x27 ;;"
        print "    *:-*) ;;"
        split(files, named, "|"); all = ""
        for (i = 1; i in named; i++) all = all (i > 1 ? " | " : "") named[i] ":*"
        print "    " all ") _shearwater_files ;;"
        print "    esac"
        print "}"
        print "complete -F _shearwater shearwater shearwater-worker"
    }' >"$out/shearwater"

records | awk -F '\t' "$shared"'
    # Inside single quotes, and inside the brackets of _arguments.
    function quoted(text) { gsub(/\x27/, "\x27\\\x27\x27", text); gsub(/\[|\]/, "\\\\&", text); gsub(/:/, "\\:", text); return text }
    function action(value) {
        if (is_words(value)) return ":value:(" words(value) ")"
        if (is_file(value)) return ":" quoted(value) ":_files"
        return value ? ":" quoted(value) ": " : ""
    }
    $1 == "command" { command = $2; order[++count] = command
                      if (command !~ /^shearwater/) commands = commands "        \x27" command ":" quoted($3) "\x27\n" }
    $1 == "usage" && $2 ~ / [A-Z]+[.][a-z]+| FILE / { files[command] = 1 }
    $1 == "option" {
        spec = "[" quoted($5) "]" action($4) "\x27"
        if ($2) line = "\x27(" $2 " " $3 ")\x27{" $2 "," $3 "}\x27" spec
        else line = "\x27" $3 spec
        options[command] = options[command] " \\\n            " line
    }
    END {
        print "#compdef shearwater shearwater-worker"
        print "# Completion of zsh for shearwater and shearwater-worker."
        print "_shearwater() {"
        print "    local command=$service"
        print "    local -a commands=("
        printf "%s", commands
        print "    )"
        print "    if [[ $service == shearwater ]]; then"
        print "        if (( CURRENT == 2 )); then _describe command commands; return; fi"
        print "        command=$words[2]"
        print "        shift words; (( CURRENT-- ))"
        print "    fi"
        print "    case $command in"
        for (i = 1; i <= count; i++) {
            name = order[i]
            print "    " name ")\n        _arguments" options[name] (files[name] ? " \\\n            \x27*:file:_files\x27" : "") " ;;"
        }
        print "    esac"
        print "}"
        print "_shearwater \"$@\""
    }' >"$out/_shearwater"
