!> The group &function of a mechanism's case file.
module taut_case_mechanism_function
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_entries, only: entries_t
   use taut_case_mechanism_part, only: part_t
   use taut_case_mechanism_table, only: read_table
   use taut_constrained_system_tables, only: name_length
   use taut_model_mechanism_builder, only: mechanism_builder_t
   use taut_model_mechanism_function, only: function_cosine, function_kinds, function_polynomial, function_ramp, &
                                            function_run_up, function_sine, function_step, function_sum, function_table, &
                                            time_function_t
   implicit none (type, external)
   private
   public :: function_group_t

   integer, parameter :: most_coefficients = 20, most_terms = 20

   !> &function.
   type, extends(part_t) :: function_group_t
      character(len=len(function_kinds)) :: kind = 'constant'
      real(wp) :: offset = 0.0_wp
      real(wp), allocatable :: amplitude, rate, frequency, omega, phase, start, finish, coefficients(:), factors(:)
      character(len=name_length), allocatable :: of(:)
      character(:), allocatable :: table
   contains
      procedure :: declare
      procedure :: add
   end type function_group_t

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(function_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries
      integer :: i

      call entries%group('function', 'a function of time, which drives a joint or scales a load')
      call self%declare_name(entries, 'by which joints and loads name it')
      call entries%item('kind', self%kind, 'constant: offset; ramp: offset + rate (t - start) from start to finish; sine and '// &
                        'cosine: offset + amplitude sin(omega t + phase); step: offset to offset + amplitude from start to '// &
                        'finish, as 10 s^3 - 15 s^4 + 6 s^5 of s from 0 to 1; run-up: its rate so, from rest at start to '// &
                        'rate at finish, and on with that; polynomial: offset + sum of coefficients(k) t^k; table: cubic '// &
                        'spline through the rows of a CSV file; sum: offset + sum of functions, each with its factor', &
                        function_kinds)
      call entries%item('offset', self%offset, '', 'is added to all kinds')
      call entries%option('amplitude', self%amplitude, '', 'of sine, cosine and step; without: 1')
      call entries%option('rate', self%rate, '1/s', 'of a ramp, and at the end of a run-up')
      call entries%option('frequency', self%frequency, 'Hz', 'of sine and cosine, in the place of omega')
      call entries%option('omega', self%omega, 'rad/s', 'of sine and cosine')
      call entries%option('phase', self%phase, 'rad', 'of sine and cosine; without: 0')
      call entries%option('start', self%start, 's', 'of a ramp, a step or a run-up; without: 0')
      call entries%option('finish', self%finish, 's', 'of a run-up; of a ramp, without: never; of a step, without: start, a '// &
                          'jump, which is for loads only')
      call entries%option('coefficients', self%coefficients, '', 'of t, t^2, ...: the first belongs to t, the constant is offset', &
                          [(i, i=1, most_coefficients)])
      call entries%option('table', self%table, 'CSV file with rows time,value; its path is from the folder of the case file; '// &
                          'it must reach from t_start to t_end')
      call entries%option('of', self%of, 'names of the functions that a sum is made of; a sum may be one of them', most_terms)
      call entries%option('factors', self%factors, '', 'what each function of a sum is multiplied with; without: 1', &
                          [(i, i=1, most_terms)])
   end subroutine declare

   !> Adds a function.
   subroutine add(self, builder, copy)
      !> What the group says.
      class(function_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> There is one.
      integer, intent(in) :: copy
      type(time_function_t) :: made

      made%name = self%copied(copy)
      made%kind = findloc(function_kinds, self%kind, 1)
      made%offset = self%offset
      if (allocated(self%amplitude)) made%amplitude = self%amplitude
      if (allocated(self%rate)) made%rate = self%rate
      if (allocated(self%phase)) made%phase = self%phase
      if (allocated(self%start)) made%start = self%start
      if (allocated(self%omega)) made%omega = self%omega
      if (allocated(self%frequency)) made%omega = 2.0_wp*acos(-1.0_wp)*self%frequency
      if (made%kind == function_step) made%finish = made%start
      if (allocated(self%finish)) made%finish = self%finish
      if (allocated(self%coefficients)) then
         made%coefficients = self%coefficients
      else
         made%coefficients = [real(wp) ::]
      end if
      if (allocated(self%of)) made%of = self%of
      if (allocated(self%factors)) made%factors = self%factors
      call check_use(self, made%kind, builder%error)
      if (allocated(self%frequency) .and. allocated(self%omega)) &
         call raise(builder%error, '', 'frequency and omega are both given', 'give one of them')
      if (any(made%kind == [function_step, function_ramp, function_run_up]) .and. made%finish < made%start) &
         call raise(builder%error, '', 'finish = '//to_text(made%finish)//' is before start', 'give a later time')
      if ((made%kind == function_table) .neqv. allocated(self%table)) &
         call raise(builder%error, '', 'table and kind do not go together', &
                    'give kind = "table" and the path of a CSV file, or neither')
      if (allocated(builder%error)) return
      if (allocated(self%table)) call read_table(self%case_path, self%table, made%times, made%values, builder%error)
      call builder%add_function(made)
   end subroutine add

   !> Refuses what a kind has no use for, and the want of what it cannot do without.
   subroutine check_use(self, kind, error)
      class(function_group_t), intent(in) :: self
      integer, intent(in) :: kind
      type(error_t), allocatable, intent(inout) :: error
      integer, parameter :: waves(2) = [function_sine, function_cosine], rates(2) = [function_ramp, function_run_up]

      call refuse('amplitude', allocated(self%amplitude), [waves, function_step])
      call refuse('rate', allocated(self%rate), rates)
      call refuse('omega', allocated(self%omega), waves)
      call refuse('frequency', allocated(self%frequency), waves)
      call refuse('phase', allocated(self%phase), waves)
      call refuse('start', allocated(self%start), [rates, function_step])
      call refuse('finish', allocated(self%finish), [rates, function_step])
      call refuse('coefficients', allocated(self%coefficients), [function_polynomial])
      call refuse('of', allocated(self%of), [function_sum])
      call refuse('factors', allocated(self%factors), [function_sum])
      if (any(rates == kind) .and. .not. allocated(self%rate)) &
         call raise(error, '', 'a '//trim(function_kinds(kind))//' without rate stands still', 'give rate')
      if (any(waves == kind) .and. .not. (allocated(self%omega) .or. allocated(self%frequency))) &
         call raise(error, '', 'a '//trim(function_kinds(kind))//' without frequency stands still', 'give frequency or omega')

   contains

      subroutine refuse(entry, given, kinds)
         character(*), intent(in) :: entry
         logical, intent(in) :: given
         integer, intent(in) :: kinds(:)

         if (given .and. all(kinds /= kind)) &
            call raise(error, '', 'kind = "'//trim(function_kinds(kind))//'" has no use for '//entry, &
                       'remove it, or give the kind that is meant')
      end subroutine refuse

   end subroutine check_use

end module taut_case_mechanism_function
