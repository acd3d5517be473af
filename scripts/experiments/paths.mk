# What the recipes of experiments share: where the tools are, and relative paths that are taken from where make was called.
root := $(abspath $(dir $(abspath $(lastword $(MAKEFILE_LIST))))../..)
# make -C changes the folder, but the caller's variable PWD still names the old one.
from := $(if $(PWD),$(PWD),$(CURDIR))
resolve = $(if $(filter /%,$(1)),$(1),$(from)/$(1))
BIN ?= $(root)/build/release/bin
bin := $(call resolve,$(BIN))
