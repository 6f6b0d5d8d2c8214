! The one file for `abaqus job=... user=quoin_abaqus.f90 double=both`.
include 'quoin.f90'
include 'quoin_joints.f90'
include 'vuinter.f90'
include 'vumat.f90'
