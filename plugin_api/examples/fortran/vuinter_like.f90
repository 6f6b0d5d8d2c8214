! A vectorised interface routine in the shape of the user subroutines of explicit finite-element codes (Abaqus VUINTER:
! blocks of nblock points, column-major arrays stress(ncomp, nblock) and state(nblock, nstatev)), with a Quoin law inside.
! Nothing is copied: every column of the law is a strided part of the code's own arrays.
!
! Signs. The code: rdisp(1, k) > 0 is penetration, stress(1, k) > 0 is pressure. Quoin: d_n > 0 opens, sigma > 0 is
! tension. Both are minus the other, so d_n and sigma are converted in place before the call and back after it; sliding
! and shear have the same sign when both are taken of the slave side against the master side.
module vuinter_like
  use quoin
  implicit none
  integer, parameter :: max_states = 16

contains

  subroutine vuinter_block(law, material, nblock, ncomp, nstatev, rdisp, drdisp, stress, state, failed)
    type(quoin_law), intent(in) :: law
    type(c_ptr), intent(in) :: material
    integer, intent(in) :: nblock, ncomp, nstatev
    real(c_double), intent(inout), target :: rdisp(ncomp, nblock)      ! total relative displacement
    real(c_double), intent(in), target :: drdisp(ncomp, nblock)        ! of this increment
    real(c_double), intent(inout), target :: stress(ncomp, nblock)     ! old in, new out
    real(c_double), intent(inout), target :: state(nblock, nstatev)    ! old in, new out
    integer(c_int64_t), intent(out) :: failed
    procedure(evaluate_function), pointer :: evaluate
    type(quoin_column), target :: states(max_states)
    type(quoin_batch) :: batch
    integer :: k

    call c_f_procpointer(law%evaluate, evaluate)
    batch%struct_size = c_sizeof(batch)
    batch%count = nblock
    batch%normal_jump = quoin_column(c_loc(rdisp(1, 1)), ncomp)
    do k = 1, 2
      batch%slip_increment(k) = quoin_column(c_loc(drdisp(k + 1, 1)), ncomp)
    end do
    do k = 1, 3
      batch%traction_old(k) = quoin_column(c_loc(stress(k, 1)), ncomp)
    end do
    batch%traction_new = batch%traction_old                            ! in place
    do k = 1, int(law%state_count)
      states(k) = quoin_column(c_loc(state(1, k)), 1)
    end do
    batch%state_old = c_loc(states)
    batch%state_new = c_loc(states)

    rdisp(1, :) = -rdisp(1, :)
    stress(1, :) = -stress(1, :)
    if (evaluate(material, batch) /= 0) error stop "the batch was refused"
    rdisp(1, :) = -rdisp(1, :)
    stress(1, :) = -stress(1, :)
    failed = batch%failed_count
  end subroutine

end module

program main
  use vuinter_like
  implicit none
  integer, parameter :: nblock = 136, ncomp = 3, nstatev = max_states
  real(c_double), parameter :: kn = 4.0e10_c_double, ks = 2.0e10_c_double
  real(c_double), target :: rdisp(ncomp, nblock), drdisp(ncomp, nblock), stress(ncomp, nblock), state(nblock, nstatev)
  real(c_double), target :: numbers(2) = [kn, ks], initial(nstatev) = 0
  character(kind=c_char, len=32), target :: ids(2)
  character(kind=c_char, len=2000), target :: message
  character(len=1000) :: path
  type(quoin_property_value), target :: values(2)
  type(c_ptr) :: pointers(2), material
  type(c_ptr), pointer :: initial_states(:)
  type(quoin_law), pointer :: law
  type(quoin_text) :: text
  procedure(create_material_function), pointer :: create_material
  procedure(initial_state_function), pointer :: initial_state
  integer(c_int64_t) :: failed
  integer :: i, step

  call get_command_argument(1, path)
  law => open_law(trim(path))
  if (.not. associated(law)) error stop "the library cannot be loaded"
  call c_f_procpointer(law%create_material, create_material)
  ids = [character(kind=c_char, len=32) :: "normal_stiffness" // c_null_char, "shear_stiffness" // c_null_char]
  do i = 1, 2
    values(i)%id = c_loc(ids(i))
    values(i)%numbers = c_loc(numbers(i))
    pointers(i) = c_loc(values(i))
  end do
  text%data = c_loc(message)
  text%capacity = len(message)
  if (create_material(law, 2_c_int64_t, pointers, material, text) /= 0) then
    print *, message(1:min(int(text%length), len(message)))
    error stop "the material was refused"
  end if
  call c_f_procpointer(law%initial_state, initial_state)
  call c_f_pointer(law%initial_states, initial_states, [law%initial_state_count])
  if (initial_state(material, initial_states(1), initial) /= 0) error stop "no initial state"
  if (law%state_count > nstatev) error stop "too many states"
  do i = 1, nstatev
    state(:, i) = initial(i)
  end do

  rdisp = 0
  stress = 0
  do step = 1, 10                       ! press and slide, every point by another amount
    do i = 1, nblock
      drdisp(:, i) = [1.0e-8_c_double * i, 2.0e-8_c_double, -1.0e-9_c_double * i]
    end do
    rdisp = rdisp + drdisp
    call vuinter_block(law, material, nblock, ncomp, nstatev, rdisp, drdisp, stress, state, failed)
    if (failed /= 0) error stop "points failed"
  end do
  do i = 1, nblock
    if (abs(stress(1, i) - kn * 1.0e-7_c_double * i) > 1e-6) error stop "pressure is wrong"
    if (abs(stress(2, i) - ks * 2.0e-7_c_double) > 1e-6) error stop "shear s is wrong"
    if (abs(stress(3, i) + ks * 1.0e-8_c_double * i) > 1e-6) error stop "shear t is wrong"
  end do
  print "(a, i0, a, f0.3, a)", "Fortran: ", nblock, " points in place, pressure of the last ", stress(1, nblock), " Pa"
end program
